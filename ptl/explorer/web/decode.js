// Unpacks the arrays of the data set; the counterpart of ptl/explorer/encoding.py.

const SHARE_STEPS = 65535;

export function decodeBytes(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i += 1) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Values >= 0 from their float32 logarithms. */
export function decodeValues(text) {
  const view = new DataView(decodeBytes(text).buffer);
  return Float64Array.from({ length: view.byteLength / 4 }, (_, i) => Math.exp(view.getFloat32(4 * i, true)));
}

/** Numbers in [0, 1] from uint16. */
export function decodeShares(text) {
  const view = new DataView(decodeBytes(text).buffer);
  return Float64Array.from({ length: view.byteLength / 2 }, (_, i) => view.getUint16(2 * i, true) / SHARE_STEPS);
}

/** Actions 0 to 3, -1 where undefined. */
export function decodeActions(text) {
  return new Int8Array(decodeBytes(text).buffer);
}

export function decodeVarints(text) {
  const numbers = [];
  let number = 0;
  let factor = 1; // not a shift: 32 bits are too few for the longest episodes
  for (const byte of decodeBytes(text)) {
    number += (byte & 0x7f) * factor;
    factor *= 128;
    if (byte < 0x80) {
      numbers.push(number);
      number = 0;
      factor = 1;
    }
  }
  return numbers;
}

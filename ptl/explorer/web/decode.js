// Unpacks the arrays of the data set; the counterpart of ptl/explorer/encoding.py.

const SHARE_STEPS = 65535;

function decodeBytes(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i += 1) bytes[i] = binary.charCodeAt(i);
  return bytes;
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

/** Runs of absent (0) and present values in turn; `read(view, i)` gives the i-th present one. */
function decodeSparse(text, read) {
  const [packed, data] = text.split(".");
  const runs = decodeVarints(packed);
  const view = new DataView(decodeBytes(data).buffer);
  const values = new Float64Array(runs.reduce((sum, run) => sum + run, 0));
  let place = 0;
  let present = 0;
  runs.forEach((run, i) => {
    for (let end = place + run; place < end; place += 1) {
      if (i % 2) {
        values[place] = read(view, present);
        present += 1;
      }
    }
  });
  return values;
}

/** Values >= 0 from their float32 logarithms. */
export function decodeValues(text) {
  return decodeSparse(text, (view, i) => Math.exp(view.getFloat32(4 * i, true)));
}

/** Numbers in [0, 1] from uint16. */
export function decodeShares(text) {
  return decodeSparse(text, (view, i) => view.getUint16(2 * i, true) / SHARE_STEPS);
}

/** A table of numbers in [0, 1]; each row but the first is kept as its change against the row before. */
export function decodeShareRows(text) {
  const [columns, ...changes] = decodeVarints(text);
  const rows = [];
  let row = new Float64Array(columns);
  for (let i = 0; i < changes.length; i += columns) {
    row = row.map((count, k) => {
      const change = changes[i + k];
      return count + (change % 2 ? -(change + 1) / 2 : change / 2);
    });
    rows.push(row);
  }
  return rows.map((counts) => counts.map((count) => count / SHARE_STEPS));
}

/** Actions 0 to 3, -1 where undefined, for a number of states. */
export function decodeActions(text, size) {
  const bytes = decodeBytes(text);
  return Int8Array.from({ length: size }, (_, i) => (Math.floor(bytes[Math.floor(i / 3)] / 5 ** (i % 3)) % 5) - 1);
}

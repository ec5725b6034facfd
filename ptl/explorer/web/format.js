// Numbers and words as the page shows them.

const NARROW_SPACE = "\u202f"; // no line break in a number

/** Whole number with groups of three digits. */
export function formatCount(number) {
  return String(Math.round(number)).replace(/\B(?=(\d{3})+$)/g, NARROW_SPACE);
}

/** Three significant digits without an exponent where that stays short. */
export function formatNumber(number) {
  if (number === 0) return "0";
  const size = Math.abs(number);
  if (size >= 1000) return formatCount(number);
  if (size < 0.001) return number.toExponential(2).replace("e-", "\u202f×\u202f10^−");
  return String(Number(number.toPrecision(3)));
}

/** A probability in per cent. */
export function formatPercent(share) {
  if (share > 0 && share < 0.005) return "<1\u202f%";
  return `${Math.round(100 * share)}\u202f%`;
}

/** How many times larger `large` is than `small`, for reading aloud. */
export function formatFactor(large, small) {
  const factor = large / small;
  return factor < 10 ? factor.toFixed(1) : formatCount(factor);
}

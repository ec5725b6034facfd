// Numbers as ptl/text.py formats them.

/** Whole number with groups of three digits. */
export function formatCount(number) {
  return Math.round(number).toLocaleString("en-US");
}

/** Four significant digits, at most three decimals; below 0.001 with an exponent. */
export function formatNumber(number) {
  if (number === 0) return "0";
  if (number < 0.001) return number.toExponential(2).replace("e-", " × 10^−");
  const decimals = Math.min(3, Math.max(0, 3 - Math.floor(Math.log10(number))));
  return Number(number.toPrecision(4)).toLocaleString("en-US", { maximumFractionDigits: decimals });
}

/** A probability as a whole percentage. */
export function formatPercent(share) {
  return share > 0 && share < 0.005 ? "<1%" : `${Math.round(100 * share)}%`;
}

/** How many times larger `large` is than `small`, for reading aloud. */
export function formatFactor(large, small) {
  const factor = large / small;
  return factor < 10 ? factor.toFixed(1) : formatCount(factor);
}

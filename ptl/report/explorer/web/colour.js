// Colours: a perceptually uniform map that the colour-blind read as well, and contrasts on it.

// Viridis at 17 equal steps.
const VIRIDIS = [
  "#440154", "#48186a", "#472d7b", "#424086", "#3b528b", "#33638d", "#2c728e", "#26828e", "#21918c",
  "#1fa088", "#28ae80", "#3fbc73", "#5ec962", "#84d44b", "#addc30", "#d8e219", "#fde725",
].map(parseHex);

// Skills carry none of the methods' colours (Paul Tol's muted scheme); no guidance is grey.
const SKILL_COLOURS = [
  "#8f949b", "#cc6677", "#ddcc77", "#44aa99", "#aa4499", "#88ccee", "#999933", "#882255", "#117733", "#6f63c0",
];

export function parseHex(text) {
  return [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16));
}

export function toHex(rgb) {
  return "#" + rgb.map((part) => Math.round(part).toString(16).padStart(2, "0")).join("");
}

export function mixColours(first, second, share) {
  return first.map((part, i) => part + (second[i] - part) * share);
}

/** Colour of t in [0, 1], from dark purple to yellow. */
export function viridis(t) {
  const place = Math.min(1, Math.max(0, t)) * (VIRIDIS.length - 1);
  const low = Math.min(Math.floor(place), VIRIDIS.length - 2);
  return mixColours(VIRIDIS[low], VIRIDIS[low + 1], place - low);
}

export function skillColour(candidate) {
  return candidate === 0
    ? SKILL_COLOURS[0]
    : SKILL_COLOURS[1 + ((candidate - 1) % (SKILL_COLOURS.length - 1))];
}

/** Relative luminance of WCAG 2. */
export function luminance(rgb) {
  const [r, g, b] = rgb.map((part) => {
    const share = part / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/** Ink that reads well on a colour. */
export function inkOn(rgb) {
  return luminance(rgb) > 0.2 ? "#14171a" : "#ffffff";
}

/** A method's colour, lightened on a dark page. */
export function methodColour(hex, dark) {
  return dark ? toHex(mixColours(parseHex(hex), [255, 255, 255], 0.3)) : hex;
}

// Small helpers for building elements.

const SVG = "http://www.w3.org/2000/svg";

function setAll(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

export function svg(name, attributes = {}, ...children) {
  return setAll(document.createElementNS(SVG, name), attributes, children);
}

export function html(name, attributes = {}, ...children) {
  return setAll(document.createElement(name), attributes, children);
}

export function byId(id) {
  return document.getElementById(id);
}

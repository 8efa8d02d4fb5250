// Colours that colour-blind people can tell apart (Okabe & Ito 2008), and scales for numbers.

export const MATERIALS = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#0072b2", "#d55e00", "#cc79a7", "#bbbbbb"];
export const INSIDE = "#9aa0a6";
export const PRODUCTS = ["#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#f0e442", "#0072b2", "#d55e00"];

// Viridis (van der Walt & Smith 2015), at nine places
const VIRIDIS = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];

export function rgb(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);
}

export const VIRIDIS_RGB = VIRIDIS.map(rgb);

export function viridis(share) {
  const place = Math.min(Math.max(share, 0), 1) * (VIRIDIS_RGB.length - 1);
  const k = Math.min(Math.floor(place), VIRIDIS_RGB.length - 2);
  return VIRIDIS_RGB[k].map((x, i) => x + (place - k) * (VIRIDIS_RGB[k + 1][i] - x));
}

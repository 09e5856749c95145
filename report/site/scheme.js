// Light or dark: as the reader's system asks, until the button is pressed. It runs before anything
// is drawn.
"use strict";
const dark = document.getElementById("dark");
let kept = {};
try {
  kept = localStorage;
} catch {
  // A browser that forbids it forgets the choice.
}
if (kept.scheme) dark.media = kept.scheme;
addEventListener("click", ({ target }) => {
  if (target.id !== "scheme") return;
  dark.media = matchMedia(dark.media).matches ? "not all" : "screen";
  kept.scheme = dark.media;
});

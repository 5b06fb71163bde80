"""A page that plays pictures. It needs no other file and no network."""

import base64
import json

PAGE = """<!DOCTYPE html>
<html><head><meta charset="utf-8"><title>planar_chain</title><style>
body { margin: 8px; font: 14px sans-serif; color: #444; background: @background@ }
canvas { display: block; max-width: 100% }
#bar { display: flex; gap: 8px; align-items: center; max-width: @width@px }
button { width: 3em } input { flex: 1 }
</style></head><body>
<canvas id="picture" width="@width@" height="@height@"></canvas>
<div id="bar"><button id="play" title="space: play, pause; arrows: one picture">❚❚</button>
<input id="place" type="range" min="0" max="@last@" value="0"></div>
<script>
const context = document.getElementById("picture").getContext("2d");
const button = document.getElementById("play"), place = document.getElementById("place");
const pictures = @pictures@.map(data => { const image = new Image(); image.src = "data:image/png;base64," + data; return image; });
let playing = true, start = performance.now(), shown = -1;
function show(k) {
  if (k === shown || !pictures[k].complete) return;
  context.drawImage(pictures[k], 0, 0);
  place.value = shown = k;
}
function pause() { playing = false; button.textContent = "▶"; }
function play() { playing = true; button.textContent = "❚❚"; start = performance.now() - 1000 * shown / @fps@; }
function tick(now) {
  if (playing) show(Math.max(0, Math.floor((now - start) * @fps@ / 1000)) % pictures.length);
  requestAnimationFrame(tick);
}
button.onclick = () => playing ? pause() : play();
place.oninput = () => { pause(); show(Number(place.value)); };
document.onkeydown = event => {
  const step = {ArrowLeft: -1, ArrowRight: 1}[event.key];
  if (step) { pause(); show((shown + step + pictures.length) % pictures.length); }
  if (event.key === " ") button.click();
  if (step || event.key === " ") event.preventDefault();
};
requestAnimationFrame(tick);
</script></body></html>
"""


def page(pictures, size, background, fps):
    """pictures: PNGs. size: of each, in pixels. background: red, green, blue."""
    data = [base64.b64encode(picture).decode() for picture in pictures]
    text = PAGE
    for key, value in (("width", size[0]), ("height", size[1]), ("last", len(pictures) - 1), ("fps", fps),
                       ("background", f"rgb{background}"), ("pictures", json.dumps(data))):
        text = text.replace(f"@{key}@", str(value))
    return text

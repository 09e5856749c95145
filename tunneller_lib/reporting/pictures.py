"""Drawings, animations and scenes as files."""

import json
import re
from html import escape
from pathlib import Path

import matplotlib
import numpy as np
import PIL.Image
from matplotlib.backends.backend_agg import FigureCanvasAgg

from ..job.atomic_write import replacement
from .style import ERROR_MAP

DPI = 200  # of a drawing
MILLISECONDS = 80  # for which a picture of an animation stands

# The viewer takes the page's element of the class content, or else all of its body.
# The words stand below it, for its bar of colours reaches down to the scene's edge.
PAGE = """<body style="display: flex; flex-direction: column; height: 100vh">
    <main class="content" role="img" aria-label="{0}"
      style="position: relative; flex: 1; min-height: 0"></main>
    <p style="margin: 0.5em 1em; color: #444">
      {0}. Drag to turn, turn the wheel to zoom, drag with shift to move.
    </p>"""


def write_picture(path, content, stamp="tunneller_lib"):
    """Write a scene, a drawing or the pictures of an animation, whole or not at all.

    Parameters
    ----------
    path : path-like
        Its suffix says how: .html for a scene that turns without a network, .png for a drawing,
        .gif for pictures.
    content : pyvista.Plotter, matplotlib.figure.Figure or iterable of (n, m, 3) uint8
        What.
    stamp : str
        Of which job it is, for the file's head.

    Returns
    -------
    path : pathlib.Path
        Where it is now.
    """
    writers = {".html": _html, ".png": _png, ".gif": _gif}
    path = Path(path)
    with replacement(path) as new:
        writers[path.suffix](new, content, stamp)
    return path


# A camera's angle is that of the height: where the window is taller than the scene was made for, it
# grows, so that nothing is cut off at the sides.
FIT = """<script>
(() => {{
  const place = document.querySelector("main.content");
  let grown = 1;
  function fit() {{
    const view = window.global.renderWindow; // where the viewer leaves it
    if (!view) return void setTimeout(fit, 50);
    const wanted = Math.max(1, ({0} * place.clientHeight) / place.clientWidth);
    for (const renderer of view.getRenderers()) {{
      const camera = renderer.getActiveCamera();
      const half = Math.tan((camera.getViewAngle() * Math.PI) / 360);
      camera.setViewAngle((360 / Math.PI) * Math.atan((half * wanted) / grown));
      camera.setParallelScale((camera.getParallelScale() * wanted) / grown);
    }}
    grown = wanted;
    view.render();
  }}
  addEventListener("resize", fit);
  fit();
}})();
</script>
</body>"""


def _html(path, plotter, stamp):
    width, height = plotter.window_size
    page = plotter.trame.export_html(None).getvalue()
    title = escape(plotter.title)
    for bar in plotter.scalar_bars.values():  # the viewer has a word of its own for them all
        page = page.replace('"Below"', json.dumps(bar.GetBelowRangeAnnotation() or "below"))
    plotter.close()
    page = re.sub("<title>.*?</title>", f"<title>{title}</title>", page, count=1)
    made = f'<meta name="generator" content="{escape(stamp)}">'
    page = page.replace("<head>", f"<head>{made}", 1)
    page = page.replace("<body>", PAGE.format(title), 1)
    head, _, tail = page.rpartition("</body>")
    page = head + FIT.format(width / height) + tail
    # The viewer inside asks its makers' site for the icon of the page; nothing else is loaded.
    page = re.sub(r"https://kitware\.github\.io/[^`\"']*", "data:,", page)
    path.write_text(page, encoding="utf-8", newline="\n")


def _png(path, drawing, stamp):
    drawing.set_dpi(DPI)
    # Not by savefig, which would draw twice, once for the layout.
    FigureCanvasAgg(drawing).print_png(path, metadata={"Comment": stamp})


def _gif(path, pictures, stamp):
    """Write pictures in 255 colours, those of the error scale and of the rest of a few pictures."""
    pictures = [PIL.Image.fromarray(pixels) for pixels in pictures]
    few = np.concatenate([*pictures[:: max(1, len(pictures) // 4)], pictures[-1]])
    scale = matplotlib.colormaps[ERROR_MAP](np.linspace(0, 1, 64), bytes=True)[:, :3]
    others = PIL.Image.fromarray(few).quantize(190, dither=PIL.Image.Dither.NONE).getpalette()
    others = np.reshape(others, (-1, 3))
    others = others[others.max(axis=1) < 248]  # nothing that white paper would be mistaken for
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *np.concatenate([scale, others]).ravel().tolist()])
    pictures = [p.quantize(palette=palette, dither=PIL.Image.Dither.NONE) for p in pictures]
    pictures[0].save(
        path,
        save_all=True,
        append_images=pictures[1:],
        duration=MILLISECONDS,
        loop=0,
        comment=stamp.encode(),
    )

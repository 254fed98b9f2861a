"""When each method of soft_texture wins: a plot of `penumbra_bench --suite methods --json FILE`.

    python3 tests/bench/plot_methods.py FILE docs/images/soft_texture_methods.svg
"""

import json
import math
import re
import sys

CASE = re.compile(r"methods\.torus_(\d+)_at_(\d+)\.(coverage|edge_flag|silhouette|auto)$")
COLORS = {"coverage": "#1f77b4", "edge_flag": "#ff7f0e", "silhouette": "#2ca02c", "auto": "#000"}
PANEL_WIDTH, PANEL_HEIGHT, MARGIN, GAP = 230, 260, 60, 24


def read(path):
    """{texels: {method: [(faces, ms)]}} in the order of faces."""
    panels = {}
    with open(path, encoding="utf-8") as file:
        for row in json.load(file):
            match = CASE.match(row["metric"])
            if match:
                faces, texels, method = int(match[1]), int(match[2]), match[3]
                panels.setdefault(texels, {}).setdefault(method, []).append((faces, row["value"]))
    return {t: {m: sorted(p) for m, p in lines.items()} for t, lines in sorted(panels.items())}


class Axis:
    """A logarithmic axis from `low` to `high`, `start` to `end` on paper."""

    def __init__(self, values, start, end):
        self.low, self.high = math.log10(min(values) * 0.8), math.log10(max(values) * 1.25)
        self.start, self.end = start, end

    def at(self, value):
        part = (math.log10(value) - self.low) / (self.high - self.low)
        return self.start + part * (self.end - self.start)

    def decades(self):
        return [10.0 ** d for d in range(math.ceil(self.low), math.floor(self.high) + 1)]


def label(x, y, text, anchor="middle", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {more}>{text}</text>'


def panel(left, texels, lines, x_axis, y_axis):
    bottom, top = MARGIN + PANEL_HEIGHT, MARGIN
    yield f'<rect x="{left}" y="{top}" width="{PANEL_WIDTH}" height="{PANEL_HEIGHT}" class="frame"/>'
    yield label(left + PANEL_WIDTH / 2, top - 8, f"{texels} × {texels} texels")
    for faces in x_axis.decades():
        x = x_axis.at(faces)
        yield f'<line x1="{x:.1f}" y1="{top}" x2="{x:.1f}" y2="{bottom}" class="grid"/>'
        yield label(x, bottom + 16, f"{faces:,.0f}")
    for ms in y_axis.decades():
        y = y_axis.at(ms)
        yield f'<line x1="{left}" y1="{y:.1f}" x2="{left + PANEL_WIDTH}" y2="{y:.1f}" class="grid"/>'
    for method, points in lines.items():
        places = [(x_axis.at(faces), y_axis.at(ms)) for faces, ms in points]
        if method == "auto":
            for x, y in places:
                yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" class="auto"/>'
        else:
            path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
            yield f'<polyline points="{path}" stroke="{COLORS[method]}" class="line"/>'


def plot(panels):
    points = [p for lines in panels.values() for line in lines.values() for p in line]
    y_axis = Axis([ms for _, ms in points], MARGIN + PANEL_HEIGHT, MARGIN)
    width = 2 * MARGIN + len(panels) * PANEL_WIDTH + (len(panels) - 1) * GAP
    height = 2 * MARGIN + PANEL_HEIGHT + 30
    yield f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}">'
    yield ("<style>text{font:12px sans-serif}.frame{fill:none;stroke:#444}.grid{stroke:#ddd}"
           ".line{fill:none;stroke-width:2}.auto{fill:none;stroke:#000;stroke-width:1.5}</style>")
    yield '<rect width="100%" height="100%" fill="#fff"/>'
    for i, (texels, lines) in enumerate(panels.items()):
        left = MARGIN + i * (PANEL_WIDTH + GAP)
        x_axis = Axis([faces for faces, _ in points], left, left + PANEL_WIDTH)
        yield from panel(left, texels, lines, x_axis, y_axis)
    for ms in y_axis.decades():
        yield label(MARGIN - 6, y_axis.at(ms) + 4, f"{ms:g}", "end")
    yield label(16, MARGIN - 8, "ms", "start")
    yield label(width / 2, MARGIN + PANEL_HEIGHT + 36, "faces of one mesh over the texture")
    for i, (method, color) in enumerate(COLORS.items()):
        name = "○ auto" if method == "auto" else f"— {method}"
        yield label(MARGIN + 110 * i, height - 14, name, "start", f'fill="{color}"')
    yield "</svg>"


if __name__ == "__main__":
    with open(sys.argv[2], "w", encoding="utf-8") as out:
        out.write("\n".join(plot(read(sys.argv[1]))) + "\n")

"""How wide shadow_width's penumbras are: a plot of `penumbra_bench --suite shadow_width --json FILE`.

    python3 tests/bench/plot_penumbras.py FILE docs/images/shadow_width_penumbras.svg
"""

import json
import re
import sys

ROW = re.compile(r"penumbra\.(\w+)\.at_(\d+)_cm\.(width|width_of_light)$")
COLORS = {"rectangle": "#1f77b4", "disk": "#ff7f0e", "sphere": "#2ca02c", "sun": "#9467bd"}
WIDTH, HEIGHT, MARGIN = 250, 200, 50


def read(path):
    """{light: [(height in m, our width, the light's)]} in the order of heights."""
    found = {}
    with open(path, encoding="utf-8") as file:
        for row in json.load(file):
            match = ROW.match(row["metric"])
            if match:
                at = found.setdefault(match[1], {}).setdefault(int(match[2]) / 100, {})
                at[match[3]] = row["value"]
    return {
        light: [(h, w["width"], w["width_of_light"]) for h, w in sorted(heights.items())]
        for light, heights in found.items()
    }


def text(x, y, words, anchor="middle"):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{words}</text>'


def panel(left, title, lines, most, unit, band=False):
    """Lines of (height, value), from 0 to `most`."""
    highest = max(h for _, points, _ in lines for h, _ in points)
    def place(h, v):
        return left + WIDTH * h / highest, MARGIN + HEIGHT * (1 - v / most)

    yield f'<rect x="{left}" y="{MARGIN}" width="{WIDTH}" height="{HEIGHT}" class="frame"/>'
    if band:
        top, bottom = place(0, 1.2)[1], place(0, 0.8)[1]
        yield f'<rect x="{left}" y="{top:.1f}" width="{WIDTH}" height="{bottom - top:.1f}" class="band"/>'
    yield text(left + WIDTH / 2, MARGIN - 10, title)
    for step in range(5):
        h, v = highest * step / 4, most * step / 4
        yield text(place(h, 0)[0], MARGIN + HEIGHT + 16, f"{h:.2g}")
        yield text(left - 6, place(0, v)[1] + 4, f"{v:.2g}{unit}", "end")
    yield text(left + WIDTH / 2, MARGIN + HEIGHT + 34, "height of the edge, m")
    for light, points, style in lines:
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in (place(h, v) for h, v in points))
        yield f'<polyline points="{path}" stroke="{COLORS[light]}" class="line" {style}/>'


def plot(lights):
    widths = [(light, [(h, ours) for h, ours, _ in rows], "") for light, rows in lights.items()]
    theirs = [
        (light, [(h, of_light) for h, _, of_light in rows], 'stroke-dasharray="4 3"')
        for light, rows in lights.items()
    ]
    ratios = [(light, [(h, o / t) for h, o, t in rows], "") for light, rows in lights.items()]
    most = max(v for _, points, _ in widths + theirs for _, v in points)
    right = 2 * MARGIN + WIDTH + 40
    total = right + WIDTH + 110
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{total}" height="{HEIGHT + 2 * MARGIN}">'
        "<style>text{font:12px sans-serif}.frame{fill:none;stroke:#888}"
        ".line{fill:none;stroke-width:1.8}.band{fill:#ddd}</style>"
        '<rect width="100%" height="100%" fill="#fff"/>'
    )
    yield from panel(MARGIN, "penumbra, 10 to 90 %; dashed: the light's own", widths + theirs, most, " m")
    yield from panel(right, "ratio; grey: within 20 %", ratios, 1.6, "", band=True)
    for i, light in enumerate(lights):
        y = MARGIN + 16 * (i + 1)
        x = right + WIDTH + 12
        yield f'<line x1="{x}" y1="{y - 4}" x2="{x + 16}" y2="{y - 4}" stroke="{COLORS[light]}" class="line"/>'
        yield text(x + 22, y, light, "start")
    yield "</svg>"


def main():
    source, target = sys.argv[1:3]
    with open(target, "w", encoding="utf-8") as file:
        file.write("\n".join(plot(read(source))) + "\n")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: MIT
"""What the pictures of the documents are drawn with: SVG without a library."""
import html

BLUE, ORANGE, GREEN, VIOLET = "#1b6ca8", "#d95f02", "#1b9e77", "#7b3294"
DARK, GREY, PALE = "#222222", "#777777", "#e6e6e6"


class Drawing:
    """An SVG of `width` x `height` pixels on white."""

    def __init__(self, width, height):
        self.lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
                      f'width="{width}" height="{height}" font-family="sans-serif" font-size="12">',
                      f'<rect width="{width}" height="{height}" fill="#ffffff"/>']

    def text(self, x, y, text, anchor="start", colour=DARK, size=12, weight="normal"):
        self.lines.append(f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" fill="{colour}" '
                          f'font-size="{size}" font-weight="{weight}">{html.escape(text)}</text>')

    def box(self, x, y, width, height, fill, line="none"):
        self.lines.append(f'<rect x="{x:.4g}" y="{y:.4g}" width="{width:.4g}" height="{height:.4g}" '
                          f'fill="{fill}" stroke="{line}"/>')

    def path(self, points, colour, width=1.0, dash=""):
        """A line through points in pixels, to a tenth."""
        steps = "L".join(f"{x:.1f} {y:.1f}" for x, y in points).replace(".0 ", " ").replace(".0L", "L")
        dash = f' stroke-dasharray="{dash}"' if dash else ""
        self.lines.append(f'<path d="M{steps}" fill="none" stroke="{colour}" '
                          f'stroke-width="{width}"{dash}/>')

    def area(self, points, colour):
        """A filled outline through points in pixels."""
        steps = "L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        self.lines.append(f'<path d="M{steps}z" fill="{colour}"/>')

    def write(self, path):
        path.write_text("\n".join(self.lines + ["</svg>"]) + "\n")


def simplified(points, tolerance):
    """Without the points that lie on the line through their neighbours (Ramer, Douglas, Peucker)."""
    if len(points) < 3:
        return points
    (x1, y1), (x2, y2) = points[0], points[-1]
    away, at = max((abs(y - (y1 + (y2 - y1) * (x - x1) / ((x2 - x1) or 1))), n)
                   for n, (x, y) in enumerate(points[1:-1], 1))
    if away <= tolerance:
        return [points[0], points[-1]]
    return simplified(points[:at + 1], tolerance)[:-1] + simplified(points[at:], tolerance)


def stairs(points):
    kept = points[:1]
    for (_, before), (x, y) in zip(points, points[1:]):
        if y != before:
            kept += [(x, before), (x, y)]
    return kept + points[-1:]

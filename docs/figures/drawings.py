#!/usr/bin/env python3
"""Draws the pictures of the theory chapters as SVG: `python3 docs/figures/drawings.py`. Needs nothing but Python."""

import math
import pathlib

IMAGES = pathlib.Path(__file__).resolve().parent.parent / "src" / "images"
INK, GREY, LIGHT, RED, BLUE, GREEN = "#22313f", "#7b8794", "#e4e9ee", "#c0392b", "#2166ac", "#2e7d4f"


class Drawing:
    """An SVG whose lengths are pixels, y upwards from `origin`."""

    def __init__(self, width, height):
        self.width, self.height, self.parts, self.origin = width, height, [], (0.0, float(height))

    def at(self, x, y):
        return self.origin[0] + x, self.origin[1] - y

    def line(self, points, color=INK, width=1.6, dash="", fill="none", closed=False):
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in (self.at(*p) for p in points))
        tag = "polygon" if closed else "polyline"
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<{tag} points="{path}" fill="{fill}" stroke="{color}" stroke-width="{width}" stroke-linejoin="round"{dashed}/>')

    def arrow(self, start, end, color=INK, width=2.0):
        (x, y), (u, v) = start, end
        length = math.hypot(u - x, v - y)
        if length < 1e-9:
            return
        dx, dy, head = (u - x) / length, (v - y) / length, min(9.0, 0.5 * length)
        base = (u - head * dx, v - head * dy)
        self.line([start, base], color, width)
        side = 0.42 * head
        tip = [(u, v), (base[0] - side * dy, base[1] + side * dx), (base[0] + side * dy, base[1] - side * dx)]
        self.line(tip, color, 0.5, fill=color, closed=True)

    def circle(self, center, radius, color=INK, width=1.6, fill="none", dash=""):
        x, y = self.at(*center)
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{fill}" stroke="{color}" stroke-width="{width}"{dashed}/>')

    def text(self, position, text, color=INK, size=15, anchor="middle", style="normal"):
        """Text in which `_{…}` is lowered."""
        x, y = self.at(*position)
        plain = text.replace("&", "&amp;").replace("<", "&lt;")
        spans = plain.replace("_{", '<tspan dy="4" font-size="75%">').replace("}", '</tspan><tspan dy="-4">​</tspan>')
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" fill="{color}" font-size="{size}" text-anchor="{anchor}" font-style="{style}">{spans}</text>'
        )

    def axes(self, x, y, x_name, y_name, left=0.0, down=0.0):
        self.arrow((-left, 0), (x, 0), GREY, 1.3)
        self.arrow((0, -down), (0, y), GREY, 1.3)
        self.text((x, -22), x_name, anchor="end")
        self.text((8, y + 4), y_name, anchor="start")

    def save(self, name, title):
        body = "\n".join(self.parts)
        (IMAGES / name).write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}" height="{self.height}" '
            f'font-family="Latin Modern Math, STIX Two Text, Georgia, serif"><title>{title}</title>\n{body}\n</svg>\n',
            encoding="utf-8",
        )


def contact_frame():
    d = Drawing(560, 300)
    d.origin = (280, 190)
    ground = [(x, -6 - 10 * math.cos(x / 95)) for x in range(-240, 241, 8)]
    d.line([*ground, (240, -100), (-240, -100)], GREY, 1.2, fill=LIGHT, closed=True)
    d.circle((0, 88), 60, INK, 1.6, fill="#f4f6f8")
    d.text((-24, 100), "B", size=18)
    d.text((-200, -70), "A", size=18)
    d.line([(0, -16), (0, 28)], GREY, 1.0, "3 3")
    d.text((-14, 2), "φ", color=GREY)
    d.arrow((0, -16), (0, 76), INK)
    d.text((12, 80), "n", style="italic")
    d.arrow((0, -16), (92, -16), INK)
    d.text((98, -34), "t_{1}", style="italic")
    d.arrow((0, 28), (-78, 12), BLUE)
    d.text((-92, 20), "c", BLUE, style="italic")
    d.arrow((0, 28), (58, 124), RED)
    d.text((66, 132), "λ on B", RED, anchor="start")
    d.text((110, 30), "−λ acts on A", RED, size=13, anchor="start")
    d.save("contact_frame.svg", "Contact frame, gap, relative velocity and impulse")


def corner_law():
    d = Drawing(600, 280)
    for x, corner in ((60, True), (360, False)):
        d.origin = (x, 230)
        d.axes(200, 190, "g_{N}", "λ_{N}", left=30, down=20)
        if corner:
            d.line([(0, 175), (0, 0), (185, 0)], RED, 3.4)
            d.text((100, 120), "pushes:", size=13, anchor="start")
            d.text((100, 102), "gap stays closed", size=13, anchor="start")
            d.arrow((94, 114), (8, 114), GREY, 1.0)
            d.text((96, 18), "opens: no impulse", size=13, anchor="start")
            d.text((90, -42), "Signorini: a corner, no parameter", size=13)
        else:
            d.line([(-28, 175), (0, 0), (185, 0)], BLUE, 3.4)
            d.line([(0, 175), (0, 0)], RED, 1.2, "4 4")
            d.text((30, 120), "stiffness and damping:", size=13, anchor="start")
            d.text((30, 102), "overlap, creep", size=13, anchor="start")
            d.text((90, -42), "softened: a slope, two parameters", size=13)
    d.save("corner_law.svg", "Signorini's law is a corner; a softened one is a slope")


def regular(count, radius, turn=0.0):
    return [(radius * math.cos(turn + 2 * math.pi * k / count), radius * math.sin(turn + 2 * math.pi * k / count)) for k in range(count)]


def friction_polygon():
    d = Drawing(660, 270)
    for x, count in ((115, 4), (330, 8), (545, 16)):
        d.origin = (x, 140)
        d.circle((0, 0), 92, GREY, 1.2, dash="4 4")
        d.line(regular(count, 92), INK, 1.8, fill=LIGHT, closed=True)
        for point in regular(count, 92):
            d.arrow((0, 0), point, GREY, 0.9)
        slip = 0.62 * 2 * math.pi / count
        d.arrow((0, 0), (-112 * math.cos(slip), -112 * math.sin(slip)), BLUE)
        vertex = max(regular(count, 92), key=lambda p: p[0] * math.cos(slip) + p[1] * math.sin(slip))
        d.arrow((0, 0), vertex, RED, 2.6)
        d.text((0, -122), f"{count} directions: ≥ {100 * math.cos(math.pi / count):.1f} %", size=13)
    d.origin = (0, 270)
    d.text((20, 252), "slip c_{T}", BLUE, anchor="start", size=13)
    d.text((84, 252), "friction λ_{T}", RED, anchor="start", size=13)
    d.text((170, 252), "Coulomb's disc of radius μλ_{N} dashed", GREY, anchor="start", size=13)
    d.save("friction_polygon.svg", "Friction polygons with 4, 8 and 16 directions inside Coulomb's disc")


def modes():
    d = Drawing(660, 260)
    cone = 0.6
    cases = (
        (110, "open", "λ = 0", None, (30, 40)),
        (330, "sticking", "c = 0, λ inside the cone", (26, 130), None),
        (550, "sliding", "c_{T} ≠ 0, λ on the boundary", (-cone * 120, 120), (70, 0)),
    )
    for x, name, law, impulse, velocity in cases:
        d.origin = (x, 200)
        d.line([(-95, 0), (95, 0)], INK, 1.8)
        d.line([(-cone * 150, 150), (0, 0), (cone * 150, 150)], GREY, 1.0, "4 4", fill="#f4f6f8")
        if impulse:
            d.arrow((0, 0), impulse, RED, 2.6)
            d.text((impulse[0] - 12, impulse[1] + 6), "λ", RED)
        if velocity:
            start = (0, 2) if name == "sliding" else (0, 14)
            d.arrow(start, (velocity[0], velocity[1] + start[1]), BLUE, 2.6)
            d.text((velocity[0] + 12, velocity[1] + 10), "c", BLUE)
        d.text((0, -24), name, size=16)
        d.text((0, -46), law, GREY, size=13)
    d.save("modes.svg", "The three modes of a contact in the plane")


def relaxation():
    d = Drawing(560, 290)
    d.origin = (70, 235)
    d.axes(400, 200, "gap velocity  φ/Δt + c_{N}", "λ_{N}", left=30, down=20)
    for k, (speed, color) in enumerate(((0.0, RED), (0.5, "#8e6bb3"), (1.0, BLUE))):
        shift = 130 * speed
        d.line([(shift, 185), (shift, 2 * k), (390, 2 * k)], color, 3.0)
    d.text((8, 150), "c_{T} = 0", RED, size=13, anchor="start")
    d.text((73, 120), "½ m/s", "#8e6bb3", size=13, anchor="start")
    d.text((138, 150), "1 m/s", BLUE, size=13, anchor="start")
    d.arrow((0, 60), (130, 60), GREY, 1.2)
    d.text((160, 64), "μ‖c_{T}‖", GREY, size=14, anchor="start")
    d.text((190, -46), "relaxed contact at three sliding speeds: the corner moves, the body lifts off", size=13)
    d.save("relaxation.svg", "The convex relaxation moves the corner of Signorini's law with the sliding speed")


for draw in (contact_frame, corner_law, friction_polygon, modes, relaxation):
    draw()

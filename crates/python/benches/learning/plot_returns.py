"""Draws the curves of train_ppo.py: python plot_returns.py results/Hopper results/PushBox writes one SVG beside each CSV."""

from __future__ import annotations

import csv
import json
import math
import pathlib
import sys
from typing import List, Sequence

WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 480, 260, 56, 40, 28, 16


def ticks(low: float, high: float, count: int = 5) -> List[float]:
    """Round numbers in [low, high]."""
    raw = (high - low) / count
    size = 10.0 ** math.floor(math.log10(raw))
    step = min((size * k for k in (1, 2, 5, 10)), key=lambda s: abs(s - raw))
    return [step * k for k in range(math.ceil(low / step), math.floor(high / step) + 1)]


def draw(name: str, steps: Sequence[float], returns: Sequence[float], random: float, trained: float) -> str:
    """The mean return over environment steps, with the levels of the random and of the trained policy."""
    low, high = min(0.0, *returns, random), max(*returns, trained, 0.0)
    margin = 0.05 * (high - low)
    low, high = low - margin, high + margin

    def x(step: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * step / steps[-1]

    def y(value: float) -> float:
        return TOP + (HEIGHT - TOP - BOTTOM) * (high - value) / (high - low)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="11" fill="#333">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
        f'<text x="{LEFT}" y="16" font-size="13">{name}: mean return of the last 100 training episodes</text>',
    ]
    for value in ticks(low, high):
        parts.append(f'<path d="M{LEFT} {y(value):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{value:g}</text>')
    for value in ticks(0.0, steps[-1]):
        parts.append(f'<text x="{x(value):.1f}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">{value / 1e6:g}</text>')
    parts.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 6}" text-anchor="middle">environment steps, millions</text>')
    for value, text, colour in ((random, "random policy", "#999"), (trained, "trained policy, without noise", "#2a7")):
        parts.append(f'<path d="M{LEFT} {y(value):.1f}H{WIDTH - RIGHT}" stroke="{colour}" stroke-dasharray="5 4"/>')
        parts.append(f'<text x="{WIDTH - RIGHT}" y="{y(value) - 4:.1f}" text-anchor="end" fill="{colour}">{text}</text>')
    path = "L".join(f"{x(s):.1f} {y(r):.1f}" for s, r in zip(steps, returns))
    parts.append(f'<path d="M{path}" fill="none" stroke="#2563c4" stroke-width="1.5"/></svg>')
    return "\n".join(parts) + "\n"


def main() -> None:
    for argument in sys.argv[1:]:
        path = pathlib.Path(argument)
        with path.with_suffix(".csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        levels = json.loads(path.with_suffix(".json").read_text())
        steps, returns = [float(r["steps"]) for r in rows], [float(r["return_mean"]) for r in rows]
        picture = draw(path.name, steps, returns, levels["random"]["return_mean"], levels["trained"]["return_mean"])
        path.with_suffix(".svg").write_text(picture)


if __name__ == "__main__":
    main()

"""Render until the error is below 5 %, with more samples where there is more noise.

Writes promised.png. The verdict is met, not met, or not certifiable.
"""

import alight

if __name__ == "__main__":
    film = alight.render("cornell-box", size=64, error="5%", adaptive=True, output="promised.png")
    own, counts = film.error.relrmse, film.sample_count
    print(film.stats["verdict"]["line"])
    print(f"error {own.value:.1%}, 95 % interval [{own.low:.1%}, {own.high:.1%}]")
    print(f"{counts.min()} to {counts.max()} samples a pixel")
    for bias in film.biases:
        print("bias:", bias.line)

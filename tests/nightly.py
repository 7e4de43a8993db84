"""How often Hypothesis draws: four times as often in the whole suite."""

import os


def draws(usual: int) -> int:
    return 4 * usual if os.environ.get("NARROWS_WHOLE") else usual

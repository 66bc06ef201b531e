"""Sheets of small pictures: which stands where."""

import numpy as np

from alight.lab.panels import sheet_of


def test_panels_of_a_sheet_stand_in_rows_of_three():
    colors = [(40 * k, 200 - 30 * k, 25 * k) for k in range(5)]
    sheet = np.asarray(sheet_of([(np.full((2, 3, 3), c, float), "") for c in colors]))
    wide, high = (sheet.shape[1] - 12) // 3, (sheet.shape[0] - 12) // 2
    for k, color in enumerate(colors):
        x, y = 12 + k % 3 * wide, 12 + k // 3 * high
        assert sheet[y, x].tolist() == [*color] and sheet[y - 1, x].tolist() == [255] * 3

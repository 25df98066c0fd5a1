"""Tables that the library writes, as arrays."""
import csv
import io
from typing import Any, Dict

import numpy as np
import numpy.typing as npt


def columns(text: str) -> Dict[str, npt.NDArray[Any]]:
    """Of a CSV file's text an array a column, by its name: numbers, NaN where a cell is empty; else words."""
    def array(cells: tuple[str, ...]) -> npt.NDArray[Any]:
        try:
            return np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            return np.array(cells)

    return {name: array(tuple(cells)) for name, *cells in zip(*csv.reader(io.StringIO(text)))}

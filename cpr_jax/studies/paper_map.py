"""What the paper says about its Figure 3, beside what the map shows."""

import numpy as np
import xarray as xr


def as_claim(claim: str, computed: str, agrees: bool, **numbers) -> dict:
    """One claim of the paper, what was computed (a sentence), and whether both agree."""
    return {"claim": claim, "computed": computed, "agrees": bool(agrees), "numbers": numbers}


def map_claims(dataset: xr.Dataset) -> list[dict]:
    """The claims about Figure 3."""
    return [_edge(dataset), _ring(dataset), _t2_line(dataset), _sides(dataset)]


def line_points(dataset: xr.Dataset, name: str) -> np.ndarray:
    """All points of the curves `t1_line` or `t2_line`, m, shape `(points, 2)`."""
    points = dataset[name].values.reshape(-1, 2)
    return points[np.isfinite(points[:, 0])]


def _solved(dataset: xr.Dataset):
    """Points and larger semi-axes of the solved cells."""
    first, second = (dataset[str(name)].values for name in dataset["status"].dims)
    grid = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1)
    solved = dataset["index"].values >= 0
    return grid[solved], dataset["semi_axis_max"].values[solved]


def _edge(dataset: xr.Dataset) -> dict:
    points, axes = _solved(dataset)
    place, least = points[np.argmin(axes)], float(np.min(axes))
    rim = line_points(dataset, "t1_line")
    gap = float(np.min(np.linalg.norm(rim - place, axis=1)))
    return as_claim(
        "The lowest sensitivity is found at the edge of the workspace.",
        f"Lowest at ({1e3 * place[0]:.0f}, {1e3 * place[1]:.0f}) mm, {1e3 * gap:.1f} mm from the "
        f"upper edge: the longer semi-axis is {1e3 * least:.2f} mm there.",
        gap < 0.01,
        point=place,
        semi_axis=least,
        distance=gap,
    )


def _central(points: np.ndarray) -> np.ndarray:
    """Points of the T2 line around the middle of the base, not those at the lower edge."""
    return points[np.linalg.norm(points, axis=1) < 0.12]


def _ring(dataset: xr.Dataset) -> dict:
    points, axes = _solved(dataset)
    upper = points[:, 1] > -0.1
    high = upper & (axes > np.percentile(axes[upper], 95.0))
    away = np.linalg.norm(points[high], axis=1)
    inside = np.linalg.norm(points, axis=1) < 0.03
    typical = float(np.median(axes[high]))
    return as_claim(
        "The high sensitivity values form a ring near the centre of the base.",
        f"Above z = -100 mm the most sensitive twentieth of the cells lies {1e3 * away.min():.0f} "
        f"to {1e3 * away.max():.0f} mm from the middle of the base; its median semi-axis is "
        f"{1e3 * typical:.0f} mm, that of all cells {1e3 * np.median(axes):.1f} mm, and that "
        f"within 30 mm of the middle {1e3 * np.median(axes[inside]):.0f} mm.",
        away.max() < 0.12 and typical > 3.0 * np.median(axes[upper]),
        nearest=float(away.min()),
        farthest=float(away.max()),
        median_ring=typical,
        median_all=float(np.median(axes)),
    )


def _t2_line(dataset: xr.Dataset) -> dict:
    points, axes = _solved(dataset)
    line = _central(line_points(dataset, "t2_line"))
    spacing = float(np.diff(dataset[str(dataset["status"].dims[0])].values)[0])
    gaps = np.array([np.min(np.linalg.norm(line - point, axis=1)) for point in points])
    near, far = axes[gaps < spacing], axes[gaps > 0.02]
    return as_claim(
        "The zones of high sensitivity match the T2 line.",
        f"Cells within {1e3 * spacing:.1f} mm of the T2 line around the base have a median "
        f"semi-axis of {1e3 * np.median(near):.0f} mm, those farther than 20 mm "
        f"{1e3 * np.median(far):.1f} mm; "
        f"{np.mean(gaps[axes > np.percentile(axes, 99.0)] < 0.01):.0%} of the most sensitive "
        "hundredth of all cells are within 10 mm of it.",
        np.median(near) > 5.0 * np.median(far),
        median_near=float(np.median(near)),
        median_far=float(np.median(far)),
    )


def _sides(dataset: xr.Dataset) -> dict:
    index = dataset["index"].values
    solved = index >= 0
    share = float(np.mean(index[solved] == 0))
    counts = {int(k): int(np.sum(index == k)) for k in np.unique(index[solved])}
    return as_claim(
        "The T2 line separates stable from unstable configurations.",
        f"{share:.1%} of the cells are stable; cells by their number of unstable directions: "
        + ", ".join(f"{k}: {n}" for k, n in counts.items())
        + ".",
        0 in counts and len(counts) > 1,
        stable_share=share,
        counts=counts,
    )

"""Medians, percentiles and ratios of samples, and how figures are written."""
import math
import statistics
from typing import Dict, List, Sequence


def median(samples: Sequence[float]) -> float:
    """The middle sample, or the mean of the middle two. Raises ValueError without samples."""
    if not samples:
        raise ValueError("there is no median of no samples")
    return statistics.median(samples)


def percentile(samples: Sequence[float], share: float) -> float:
    """The least sample that at least `share` (0..1) of all do not exceed (nearest rank)."""
    if not samples:
        raise ValueError("there is no percentile of no samples")
    if not 0 < share <= 1:
        raise ValueError(f"a percentile's share is above 0 and at most 1; it is {share}")
    return sorted(samples)[math.ceil(share * len(samples)) - 1]


def summary(samples: Sequence[float]) -> Dict[str, float]:
    """Median, 95th percentile, least, and how many."""
    return {"median": rounded(median(samples)), "p95": rounded(percentile(samples, 0.95)),
            "min": rounded(min(samples)), "samples": len(samples)}


def rounded(value: float) -> float:
    """Four significant digits: more are never repeatable."""
    if value == 0:
        return 0.0
    return round(value, max(0, 3 - math.floor(math.log10(abs(value)))))


def pairwise_ratio(ours: Sequence[float], others: Sequence[float]) -> float:
    """The median of each sample over its neighbor in time: what else the computer does is then
    the same for both."""
    if len(ours) != len(others):
        raise ValueError(f"{len(ours)} samples cannot be paired with {len(others)}")
    return median([mine / other for mine, other in zip(ours, others)])


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A markdown table. Every row is as long as the head."""
    for row in rows:
        if len(row) != len(head):
            raise ValueError(f"a row of {len(row)} cells in a table of {len(head)}: {row}")
    lines: List[str] = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)

"""The goals, in one place: what is measured, against what, and how much better it must be.

A figure's name is work/topology/size/load, or its first parts where the rest says nothing:
"frames_per_s/default/512x512/skin", "first_picture_s/default".
"""
from typing import Dict, List, NamedTuple, Optional

KEYS = ("skin", "muscle", "bone", "ultrasound", "head")
SMALL, LARGE = "512x512", "1280x1024"

# Times of the alternatives in ms, by load, from the statement of the goals. They were measured on 2
# cores (Zen 5, 4.1 GHz). A run with peers uses its own times instead.
FLYING_EDGES_MS = dict(zip(KEYS, (2.0, 4.4, 2.1, 3.0, 11.5)))
VTK_SMALL_MS = dict(zip(KEYS, (14.1, 24.5, 12.1, 17.1, 51.0)))
VTK_LARGE_MS = dict(zip(KEYS, (23.4, 56.0, 32.0, 39.0, 84.0)))
VTK_LOOP_MS = dict(zip(KEYS, (11.8, 34.0, 15.0, 20.0, 67.0)))
FLYING_EDGES_BIG_MS = 148.0  # 512x512x300.
PAPER_RATES = dict(zip(KEYS, (20.0, 8.0, 19.0, 12.0, 3.0)))  # Yoo & Chen, figures 3 to 7.


class Goal(NamedTuple):
    """`figure` is to be at most (or at least) `factor` times the baseline."""
    figure: str
    at_most: bool
    factor: float
    baseline: float
    peer: Optional[str] = None  # Name of the peer's figure that replaces the baseline.

    def limit(self, peers: Dict[str, float]) -> float:
        """In the figure's unit. A peer's figures are in ms; rates are 1000 / ms."""
        measured = peers.get(self.peer) if self.peer else None
        if measured is None:
            return self.factor * self.baseline
        return self.factor * (measured if self.at_most else 1000 / measured)

    def is_met(self, value: float, peers: Dict[str, float]) -> bool:
        limit = self.limit(peers)
        return value <= limit if self.at_most else value >= limit


def _by_load(key: str) -> List[Goal]:
    rate, small, large = "frames_per_s", VTK_SMALL_MS[key], VTK_LARGE_MS[key]
    return [
        Goal(f"extraction_ms/default/{key}", True, 0.5, FLYING_EDGES_MS[key],
             f"vtk_extraction_ms/{key}"),
        Goal(f"{rate}/default/{SMALL}/{key}", False, 4, 1000 / small, f"vtk_draw_ms/{SMALL}/{key}"),
        Goal(f"{rate}/default/{LARGE}/{key}", False, 5, 1000 / large, f"vtk_draw_ms/{LARGE}/{key}"),
        Goal(f"isovalue_picture_ms/default/{SMALL}/{key}", True, 0.35, VTK_LOOP_MS[key],
             f"vtk_loop_ms/{SMALL}/{key}"),
        Goal(f"{rate}/default/{SMALL}/{key}", False, 10, PAPER_RATES[key]),
        Goal(f"{rate}/paper-1993/{SMALL}/{key}", False, 1.5, 1000 / small,
             f"vtk_draw_ms/{SMALL}/{key}"),
    ]


GOALS: List[Goal] = [goal for key in KEYS for goal in _by_load(key)] + [
    Goal("extraction_ms/default/512x512x300", True, 0.5, FLYING_EDGES_BIG_MS,
         "vtk_extraction_ms/512x512x300"),
    Goal(f"view_picture_ms/default/{SMALL}/skin", True, 1, 6.0),
    Goal("triangles_8px_per_s", False, 1, 12e6),
    Goal("end_of_region_us", True, 1, 40.0),
    Goal("memory_mib/paper-1993", True, 1, 229.0),
    Goal("first_picture_s/default", True, 1, 0.3),
    Goal("first_picture_s/paper-1993", True, 1, 0.6),
    Goal("flight_ratio/default", False, 1, 0.9),
]


# Of two views with depths, and of depths alone, against one view: stereo.py.
GOALS += [Goal(f"{row}_ratio/default/{size}/{scene}", True, 1, limit)
          for row, limit in (("pair_depths", 2.2), ("view_depths", 1.08))
          for size in (SMALL, "1024x1024") for scene in ("pelvis", "chest")]


class Verdict(NamedTuple):
    goal: Goal
    value: float
    limit: float
    met: bool


def judge(figures: Dict[str, float], peers: Optional[Dict[str, float]] = None) -> List[Verdict]:
    """Every goal whose figure was measured. peers  The peers' medians of the same session."""
    peers = peers or {}
    return [Verdict(goal, figures[goal.figure], goal.limit(peers),
                    goal.is_met(figures[goal.figure], peers))
            for goal in GOALS if goal.figure in figures]


def text_of(verdict: Verdict) -> str:
    """One line: "missed: frames_per_s/default/512x512/skin is 174, the goal is at least 284"."""
    goal, value, limit, met = verdict
    bound = "at most" if goal.at_most else "at least"
    return (f"{'met' if met else 'missed'}: {goal.figure} is {value:.4g}, "
            f"the goal is {bound} {limit:.4g}")

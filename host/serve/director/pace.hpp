// How large pictures are drawn while something moves.
#pragma once

namespace pxpl5::host::serve {

inline constexpr double goal_ms = 40;  ///< A frame: 25 a second.

/// Chooses 1, 3/4 or 1/2 of the wished size from what frames have cost. It goes down at once when a
/// frame is late, and up only after several that would have been in time at the next size, so that
/// the picture does not jump to and fro.
class Pace {
  public:
    double scale() const;
    /// A frame at scale() took so long, all work for it included.
    void drawn(double ms);

  private:
    int step_ = 0;   ///< Into the list of scales.
    int quick_ = 0;  ///< Frames in a row that let the next one be larger.
};

}  // namespace pxpl5::host::serve

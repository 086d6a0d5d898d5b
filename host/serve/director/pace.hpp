// Chooses the size of moving pictures.
#pragma once

namespace pxpl5::host::serve {

inline constexpr double goal_ms = 40;  ///< Time per frame: 25 frames per second.

/// Chooses 1, 3/4 or 1/2 of the requested size from the times of earlier frames. A late frame makes
/// the size smaller at once. Only several frames that would be in time at the next size make it
/// larger, so that the size does not oscillate.
class Pace {
  public:
    double scale() const;
    /// Reports the total time of a frame at scale().
    ///
    /// is_whole  False if a part of the picture was kept from an earlier frame. The time then says
    ///           nothing about a larger size, at which all would be drawn.
    void drawn(double ms, bool is_whole = true);

  private:
    int step_ = 0;   ///< Index into the list of scales.
    int quick_ = 0;  ///< Consecutive frames that allow a larger size.
};

}  // namespace pxpl5::host::serve

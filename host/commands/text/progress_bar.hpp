// A bar on standard error during long work.
#pragma once

#include "host/session/session.hpp"

namespace pxpl5::host {

/// Draws a bar of loads, and of commands that draw or measure again and again, if standard error is
/// a terminal and nothing else shows the progress. Draws nothing in the first moments, so that
/// short work does not flicker.
class ProgressBar {
  public:
    explicit ProgressBar(Session& session);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

  private:
    void show(const char* phase, int done, int total);

    Session& session_;
    std::int64_t started_ns_;
    bool draws_ = false;  ///< It is this bar that the session tells.
    bool drawn_ = false;
};

}  // namespace pxpl5::host

// A picture of several samples per pixel is the mean of several frames, its passes. Plain.
#pragma once

namespace pxpl5 {

/// One pass of a picture. A picture of one sample per pixel has one pass.
struct Pass {
    int sample = 0;   ///< 0 .. samples - 1.
    int samples = 1;  ///< One of sample_counts.
    bool is_last() const { return sample + 1 == samples; }
};

}  // namespace pxpl5

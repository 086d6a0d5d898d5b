#include "host/phantom/noise.hpp"

namespace pxpl5::host::phantom {

double sine(double turns) {
    double t = turns - std::floor(turns + 0.5);  // In [-1/2, 1/2).
    // The sine is symmetric about a quarter turn; the series is good only up to there.
    if (t > 0.25) t = 0.5 - t;
    if (t < -0.25) t = -0.5 - t;
    const double x = t * 6.283185307179586, xx = x * x;
    double term = x, sum = x;
    for (int k = 1; k <= 10; ++k) {
        term *= -xx / ((2.0 * k) * (2.0 * k + 1.0));
        sum += term;
    }
    return sum;
}

}  // namespace pxpl5::host::phantom

#include "host/machine/computers/network_rate.hpp"

namespace pxpl5::host {

namespace {

constexpr int rounds = 3;
constexpr double fast_enough_mb_s = 4;  // For large answers.

}  // namespace

std::optional<double> measured_mb_s(const AskForBytes& ask) {
    NetworkRate rate;
    for (int round = 0; round < rounds; ++round) {
        const auto ns = ask(0);
        if (!ns) {
            return std::nullopt;
        }
        rate.add_empty(*ns);
    }
    const auto rate_of = [&](std::uint32_t bytes, double enough_mb_s) {
        std::optional<double> mb_s;
        for (int round = 0; round < rounds && mb_s.value_or(0) < enough_mb_s; ++round) {
            const auto ns = ask(bytes);
            if (!ns) {
                break;
            }
            rate.add_full(bytes, *ns);
            mb_s = rate.mb_s();
        }
        return mb_s;
    };
    const auto small_mb_s = rate_of(small_answer_bytes, fast_enough_mb_s);
    return small_mb_s.value_or(0) < fast_enough_mb_s
               ? small_mb_s
               : rate_of(large_answer_bytes, std::numeric_limits<double>::infinity());
}

}  // namespace pxpl5::host

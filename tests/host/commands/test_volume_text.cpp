// Tests texts about a volume.
#include <doctest/doctest.h>

#include "host/commands/text/volume_text.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

TEST_CASE("pictures of a volume whose place is assumed have a warning") {
    Volume volume;
    volume.name = "head";
    CHECK(place_warning(volume).empty());
    volume.findings.push_back({FindingKind::note, "no unit of length"});
    CHECK(place_warning(volume).empty());
    volume.findings.push_back({FindingKind::assumption, "no patient space"});
    CHECK(place_warning(volume) == "place or spacing ASSUMED");
}

TEST_CASE("a time is printed to the microsecond, without the rounding of sums") {
    CHECK(ms_text(29 * 33.333) == "966.657");
    CHECK(ms_text(24 * 41.667) == "1000.008");
    CHECK(ms_text(870) == "870");
}

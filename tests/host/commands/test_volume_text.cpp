// Tests texts about a volume.
#include <doctest/doctest.h>

#include "host/commands/text/volume_text.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

TEST_CASE("the legend of an assumed place begins with the warning, which is not cut off") {
    Volume volume;
    volume.name = "head";
    CHECK(legend_title(volume) == "head");
    volume.findings.push_back({FindingKind::note, "no unit of length"});
    CHECK(legend_title(volume) == "head");
    volume.findings.push_back({FindingKind::assumption, "no patient space"});
    CHECK(legend_title(volume) == "place or spacing ASSUMED (see info): head");
}

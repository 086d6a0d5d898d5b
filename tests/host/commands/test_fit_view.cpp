// The first view of every built-in volume.
#include "tests/host/commands/fit_check.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

TEST_CASE("the first view of every built-in volume shows its surfaces whole and large") {
    for (const PhantomInfo& info : phantoms()) {
        test::check_first_view(make_phantom(info.name),
                               {"anterior", "left", "inferior", "posterior"});
    }
}

TEST_CASE("a view without surfaces shows the volume, and hidden surfaces do not count") {
    const Volume volume = make_phantom("phantom:sphere");
    Surface small;
    small.isovalue = 0.9 * volume.maximum + 0.1 * volume.minimum;
    const Camera whole = fitted_to_surfaces(volume, {}, {});
    CHECK(fitted_to_surfaces(volume, {{small}}, {}).zoom > 1.2 * whole.zoom);
    small.visible = false;
    CHECK(fitted_to_surfaces(volume, {{small}}, {}) == whole);
}

// Takes the place of the server in a build without PXPL5_SERVE.
#include "host/base/error.hpp"
#include "host/serve/serve.hpp"

namespace pxpl5::host::serve {

int serve(const ServeOptions& /*options*/) {
    throw RequestError(ExitCode::usage,
                       "this program was built without the viewer; build it with -DPXPL5_SERVE=ON");
}

}  // namespace pxpl5::host::serve

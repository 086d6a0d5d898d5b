// Findings about pixels as fields, for programs.
#pragma once

#include "host/base/reply.hpp"
#include "host/inspect/why/why.hpp"

namespace pxpl5::host::inspect {

Fields why_fields(const WhyFinding& finding);
Fields triangle_fields(const TriangleName& name);

}  // namespace pxpl5::host::inspect

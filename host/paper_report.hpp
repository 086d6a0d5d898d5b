// The paper's results table, run again on this machine.
#pragma once

#include <string>

#include "host/session.hpp"

namespace pxpl5::host {

/// Builds and draws the five surfaces of Yoo & Chen (figures 3 to 7) from the built-in volumes, and
/// prints triangles, extraction time and frame rate beside the paper's.
///
/// machine    What the pictures are drawn by, as size_text() says it.
/// pictures   Folder for the five pictures, made if absent; none are written if empty.
/// Throws     RequestError, MachineError.
void report_paper(Session& session, const std::string& machine, const std::string& pictures);

}  // namespace pxpl5::host

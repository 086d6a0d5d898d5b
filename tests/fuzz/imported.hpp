// The promises of import_volume().
#pragma once

#include "host/io/values/import_request.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

/// Reads crop, resampling and smoothing from `bytes`, so that results stay small.
void add_processing(Bytes& bytes, host::io::ImportRequest& request);

/// Imports a file or a folder. A volume has the size and the range of its values, and the ring
/// takes its header; a refusal names the file.
/// Returns  true if there is a volume.
bool imports(const host::io::ImportRequest& request);

}  // namespace pxpl5::fuzz

// Checks the files that GPs read the values of a volume from.
#pragma once

#include <string>
#include <vector>

#include "ringbus/message.hpp"
#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host {

/// Checks that the io process of `request` may read the files itself (host/io/request_needs.cpp),
/// and that their facts are those that the io process states. A file is that of the request, or
/// lies in its folder or below. If the format of the request's file names data files, a file may
/// also lie in the header's folder or below, or in one of the folders of --allow, links followed.
/// Throws RequestError (bad_data) naming the file and both values, also if the request has the host
/// read the values, or if the file system does not answer.
void check_slices_files(const StoredVolume& stored, const bus::schema::ImportVolumeT& request,
                        const std::vector<std::string>& folders);

/// Checks that the facts of the files from which GPs have read the volume of `source` are still the
/// same. Throws RequestError (bad_data) naming the file and both values.
void check_unchanged(const StoredVolume& stored, const std::string& source);

}  // namespace pxpl5::host

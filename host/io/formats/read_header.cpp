#include "host/io/formats/read_header.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace pxpl5::host::io {

StoredHeader read_stored_header(const std::filesystem::path& path, Format format,
                                const ImportRequest& request) {
    switch (format) {
        case Format::nrrd:
            return read_nrrd_header(path, request.allowed, request.frame);
        case Format::meta_image:
            return read_meta_header(path, request.allowed, request.frame);
        case Format::nifti:
            return read_nifti_header(path, request.allowed, request.frame);
        case Format::mgh:
            return read_mgh_header(path, request.frame);
        case Format::vtk:
            refuse_frame(path.string(), request);
            return read_vtk_header(path);
        case Format::vti:
            refuse_frame(path.string(), request);
            return read_vti_header(path, request.orientation);
        case Format::dicom:
        case Format::pictures:
        case Format::packed:
            break;
    }
    throw std::logic_error("this format has no header of its own");
}

void refuse_frame(const std::string& source, const ImportRequest& request) {
    if (request.frame > 1) {
        throw ImportError(
            fmt::format("{}: frame is {}, but only DICOM, NIfTI, NRRD, MetaImage and MGH files "
                        "hold time series that are read",
                        source, request.frame));
    }
}

}  // namespace pxpl5::host::io

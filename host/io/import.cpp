// The only file that includes ITK. It uses the readers themselves: the factories would try every
// format on every file, and choose by the suffix in the end.
#include "host/io/import.hpp"

#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkVTKImageIO.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <new>

#include "host/io/decoded.hpp"
#include "host/io/dicom_series.hpp"
#include "host/io/stored_header.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

/// The sentence of ITK's text that means something to a user, without C++ files and objects.
std::string useful_sentence(const itk::ExceptionObject& error) {
    std::string text = error.GetDescription();
    const std::size_t object = text.find("): ");
    if (text.find("ITK ERROR: ") != std::string::npos && object != std::string::npos) {
        text = text.substr(object + 3);
    }
    const std::size_t trouble = text.rfind("[nrrd] ");
    if (trouble != std::string::npos) {
        const std::size_t colon = text.find(": ", trouble);
        text = text.substr(colon == std::string::npos ? trouble : colon + 2);
    }
    std::replace(text.begin(), text.end(), '\n', ' ');
    const std::size_t last = text.find_last_not_of(" .");
    return last == std::string::npos ? "cannot be decoded" : text.substr(0, last + 1);
}

itk::ImageIOBase::Pointer make_reader(Format format) {
    switch (format) {
        case Format::nrrd:
            return itk::NrrdImageIO::New().GetPointer();
        case Format::meta_image:
            return itk::MetaImageIO::New().GetPointer();
        case Format::vtk:
            return itk::VTKImageIO::New().GetPointer();
        case Format::dicom:
            return itk::GDCMImageIO::New().GetPointer();
        case Format::nifti:
            break;
    }
    return itk::NiftiImageIO::New().GetPointer();
}

StoredHeader read_header(const fs::path& path, Format format) {
    switch (format) {
        case Format::nrrd:
            return read_nrrd_header(path);
        case Format::meta_image:
            return read_meta_header(path);
        case Format::vtk:
            return read_vtk_header(path);
        default:
            break;
    }
    return read_nifti_header(path);
}

Component component_of(const std::string& file, const itk::ImageIOBase& io) {
    const std::size_t bytes = io.GetComponentSize();
    using itk::IOComponentEnum;
    switch (io.GetComponentType()) {
        case IOComponentEnum::FLOAT:
            return Component::float32;
        case IOComponentEnum::DOUBLE:
            return Component::float64;
        case IOComponentEnum::UCHAR:
        case IOComponentEnum::USHORT:
        case IOComponentEnum::UINT:
        case IOComponentEnum::ULONG:
        case IOComponentEnum::ULONGLONG:
            return bytes == 1   ? Component::uint8
                   : bytes == 2 ? Component::uint16
                   : bytes == 4 ? Component::uint32
                                : Component::uint64;
        case IOComponentEnum::CHAR:
        case IOComponentEnum::SHORT:
        case IOComponentEnum::INT:
        case IOComponentEnum::LONG:
        case IOComponentEnum::LONGLONG:
            return bytes == 1   ? Component::int8
                   : bytes == 2 ? Component::int16
                   : bytes == 4 ? Component::int32
                                : Component::int64;
        default:
            break;
    }
    throw ImportError(
        fmt::format("{}: values are of type {}, which is not read", file,
                    itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType())));
}

glm::dmat4 voxel_to_patient(const itk::ImageIOBase& io) {
    glm::dmat4 affine(1.0);
    for (unsigned column = 0; column < 3; ++column) {
        for (unsigned row = 0; row < 3; ++row) {
            affine[static_cast<int>(column)][static_cast<int>(row)] =
                io.GetDirection(column)[row] * io.GetSpacing(column);
        }
        affine[3][static_cast<int>(column)] = io.GetOrigin(column);
    }
    return affine;
}

/// Dimensions as the decoder sees them, without the ones at the end.
std::array<int, 3> decoded_dims(const std::string& file, const itk::ImageIOBase& io) {
    unsigned axes = io.GetNumberOfDimensions();
    while (axes > 3 && io.GetDimensions(axes - 1) == 1) {
        --axes;
    }
    if (axes != 3) {
        throw ImportError(fmt::format("{}: has {} axes, a volume has 3", file, axes));
    }
    if (io.GetNumberOfComponents() != 1) {
        throw ImportError(
            fmt::format("{}: has {} components for each voxel (colour or vectors), "
                        "a volume has 1",
                        file, io.GetNumberOfComponents()));
    }
    std::array<int, 3> dims{};
    for (unsigned axis = 0; axis < 3; ++axis) {
        if (io.GetDimensions(axis) > max_dim) {
            throw ImportError(fmt::format("{}: {} voxels along {}, must be {} to {}", file,
                                          io.GetDimensions(axis), "xyz"[axis], min_dim, max_dim));
        }
        dims[axis] = static_cast<int>(io.GetDimensions(axis));
    }
    return dims;
}

/// Reads all voxels. ReadImageInformation has been called.
Decoded decode(const std::string& file, itk::ImageIOBase& io) {
    Decoded decoded;
    decoded.dims = decoded_dims(file, io);
    decoded.component = component_of(file, io);
    decoded.voxel_to_patient = voxel_to_patient(io);
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
        region.SetIndex(axis, 0);
        region.SetSize(axis, io.GetDimensions(axis));
    }
    io.SetIORegion(region);
    decoded.values.resize(static_cast<std::size_t>(io.GetImageSizeInBytes()));
    io.Read(decoded.values.data());
    return decoded;
}

std::string tag(const itk::ImageIOBase& io, const char* number) {
    std::string value;
    itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), number, value);
    return value.substr(0, value.find_last_not_of(" \0") + 1);
}

/// Whether `path` begins as a DICOM file and holds at least one element: on less, GDCM aborts.
bool begins_as_dicom(const fs::path& path) {
    constexpr std::size_t preamble_bytes = 132, element_bytes = 8;
    std::array<char, preamble_bytes + element_bytes> head{};
    std::ifstream stream(path, std::ios::binary);
    stream.read(head.data(), head.size());
    return stream && std::string_view(head.data(), head.size()).substr(128, 4) == "DICM";
}

/// What the header of one DICOM file says. Empty if the file is no DICOM image.
std::optional<DicomSlice> read_dicom_header(const fs::path& path) {
    auto io = itk::GDCMImageIO::New();
    if (!begins_as_dicom(path) || !io->CanReadFile(path.c_str())) {
        return std::nullopt;
    }
    io->SetFileName(path.string());
    io->ReadImageInformation();
    const glm::dmat4 affine = voxel_to_patient(*io);
    DicomSlice slice;
    slice.path = path;
    slice.series = tag(*io, "0020|000e");
    slice.columns = static_cast<int>(io->GetDimensions(0));
    slice.rows = static_cast<int>(io->GetDimensions(1));
    slice.frames = io->GetNumberOfDimensions() > 2 ? static_cast<int>(io->GetDimensions(2)) : 1;
    slice.x_step_mm = glm::dvec3(affine[0]);
    slice.y_step_mm = glm::dvec3(affine[1]);
    slice.origin_mm = glm::dvec3(affine[3]);
    slice.spacing_stated = !tag(*io, "0028|0030").empty();
    slice.position_stated = !tag(*io, "0020|0032").empty() && !tag(*io, "0020|0037").empty();
    return slice;
}

/// The voxels of one slice of a series.
Decoded decode_slice(const fs::path& path) {
    auto io = itk::GDCMImageIO::New();
    io->SetFileName(path.string());
    io->ReadImageInformation();
    return decode(path.string(), *io);
}

/// A DICOM file given by itself must hold many frames.
void check_multiframe(const std::string& file, const itk::ImageIOBase& io, StoredHeader& header) {
    if (io.GetNumberOfDimensions() < 3 || io.GetDimensions(2) == 1) {
        throw ImportError(
            fmt::format("{}: is a single slice of {}x{}: give the folder of its series", file,
                        io.GetDimensions(0), io.GetDimensions(1)));
    }
    // The decoder looks into the functional groups, and says 1 when it has found nothing.
    header.spacing_stated = !tag(io, "0028|0030").empty() || io.GetSpacing(0) != 1 ||
                            io.GetSpacing(1) != 1 || io.GetSpacing(2) != 1;
}

Volume import_checked(const fs::path& path) {
    const std::string file = path.string();
    const Format format = format_of(path);
    if (fs::is_directory(path)) {
        return to_volume(file, assemble_series(path, read_dicom_header, decode_slice));
    }
    StoredHeader header;
    if (format != Format::dicom) {
        header = read_header(path, format);
    }
    if (format == Format::dicom && !begins_as_dicom(path)) {
        throw ImportError(file + ": is no DICOM file: 'DICM' and an element must follow byte 128");
    }
    const itk::ImageIOBase::Pointer io = make_reader(format);
    io->SetFileName(file);
    io->ReadImageInformation();
    if (format == Format::dicom) {
        check_multiframe(file, *io, header);
    }
    Decoded decoded = decode(file, *io);
    decoded.scaled_integers = header.scaled_integers;
    decoded.notes = header.notes;
    if (!header.spacing_stated) {
        decoded.notes.insert(decoded.notes.begin(),
                             "the file does not state its spacing: 1 mm is assumed where it is "
                             "missing, sizes and shapes may be wrong");
    }
    return to_volume(file, std::move(decoded));
}

/// "ct/pelvis.nii.gz" -> "pelvis".
std::string name_of(const fs::path& path) {
    const fs::path tidy = fs::absolute(path).lexically_normal();
    const fs::path last = tidy.has_filename() ? tidy.filename() : tidy.parent_path().filename();
    if (fs::is_directory(path)) {
        return last.string();
    }
    return last.extension() == ".gz" ? last.stem().stem().string() : last.stem().string();
}

}  // namespace

Volume import_volume(const std::string& path) {
    try {
        itk::Object::GlobalWarningDisplayOff();
        Volume volume = import_checked(path);
        volume.name = name_of(path);
        return volume;
    } catch (const itk::ExceptionObject& error) {
        throw ImportError(fmt::format("{}: {}", path, useful_sentence(error)));
    } catch (const std::bad_alloc&) {
        throw ImportError(path + ": does not fit in the memory that the io process may use");
    } catch (const fs::filesystem_error& error) {
        throw ImportError(fmt::format("{}: {}", path, error.code().message()));
    }
}

}  // namespace pxpl5::host::io

#if defined(__SANITIZE_ADDRESS__)
// The NRRD reader leaks what it holds when it meets a broken file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libITKNrrdIO";
}
#endif

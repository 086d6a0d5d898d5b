// The pixels of DICOM files.
#include <fmt/format.h>
#include <gdcmImageReader.h>

#include <algorithm>

#include "host/io/dicom/dicom_file.hpp"

namespace pxpl5::host::io {

namespace fs = std::filesystem;

struct DicomPixels::File {
    fs::path path;
    Component component = Component::uint8;
    std::vector<char> values;
};

DicomPixels::DicomPixels() : file_(std::make_unique<File>()) {}
DicomPixels::~DicomPixels() = default;

namespace {

Component component_of(const std::string& file, const gdcm::PixelFormat& format) {
    switch (format.GetScalarType()) {
        case gdcm::PixelFormat::UINT8:
            return Component::uint8;
        case gdcm::PixelFormat::INT8:
            return Component::int8;
        case gdcm::PixelFormat::UINT16:
            return Component::uint16;
        case gdcm::PixelFormat::INT16:
            return Component::int16;
        case gdcm::PixelFormat::UINT32:
            return Component::uint32;
        case gdcm::PixelFormat::INT32:
            return Component::int32;
        case gdcm::PixelFormat::FLOAT32:
            return Component::float32;
        case gdcm::PixelFormat::FLOAT64:
            return Component::float64;
        default:
            break;
    }
    throw ImportError(fmt::format("{}: pixels are of type {}, which is not read", file,
                                  format.GetScalarTypeAsString()));
}

/// GDCM asserts on more than four samples.
void check_gray(const std::string& file, const DicomSlice& slice) {
    if (slice.samples != 1) {
        throw ImportError(
            fmt::format("{}: samples per pixel (0028,0002) are {}, must be 1: color is not read",
                        file, slice.samples));
    }
}

/// Broken sizes must not become gigabytes: nothing compresses so well.
void check_ratio(const std::string& file, const DicomSlice& slice) {
    constexpr std::uint64_t unsuspicious_bytes = std::uint64_t{1} << 29, max_ratio = 1000;
    const std::uint64_t pixels = static_cast<std::uint64_t>(slice.stored_columns()) *
                                 static_cast<std::uint64_t>(slice.stored_rows()) *
                                 static_cast<std::uint64_t>(slice.frames);
    const std::uint64_t has = fs::file_size(slice.path);
    if (pixels > unsuspicious_bytes && pixels / max_ratio > has) {
        throw ImportError(fmt::format("{}: states {}x{}x{} pixels, but has {} bytes", file,
                                      slice.stored_columns(), slice.stored_rows(), slice.frames,
                                      has));
    }
}

void check_pixels(const std::string& file, const DicomSlice& slice, const gdcm::Image& image,
                  std::size_t needed) {
    const gdcm::PixelFormat& format = image.GetPixelFormat();
    if (format.GetSamplesPerPixel() != 1 ||
        image.GetPhotometricInterpretation() == gdcm::PhotometricInterpretation::PALETTE_COLOR) {
        throw ImportError(fmt::format(
            "{}: samples per pixel (0028,0002) are {}, photometric interpretation "
            "(0028,0004) is {}: color is not read",
            file, format.GetSamplesPerPixel(), image.GetPhotometricInterpretation().GetString()));
    }
    const unsigned frames = image.GetNumberOfDimensions() > 2 ? image.GetDimension(2) : 1;
    if (image.GetDimension(0) != static_cast<unsigned>(slice.stored_columns()) ||
        image.GetDimension(1) != static_cast<unsigned>(slice.stored_rows()) ||
        frames != static_cast<unsigned>(slice.frames)) {
        throw ImportError(
            fmt::format("{}: its pixel data hold {}x{}x{}, its header states {}x{}x{}", file,
                        image.GetDimension(0), image.GetDimension(1), frames,
                        slice.stored_columns(), slice.stored_rows(), slice.frames));
    }
    if (image.GetBufferLength() != needed) {
        throw ImportError(fmt::format("{}: its pixel data decode to {} bytes, {}x{}x{} need {}",
                                      file, image.GetBufferLength(), slice.stored_columns(),
                                      slice.stored_rows(), slice.frames, needed));
    }
}

/// The values of one frame, or of one tile of it.
std::vector<std::byte> tile_of(std::span<const std::byte> frame, const DicomSlice& slice,
                               std::size_t value_bytes) {
    const std::size_t row_bytes = static_cast<std::size_t>(slice.columns) * value_bytes;
    const auto across = static_cast<std::size_t>(slice.tiles_across);
    const auto tile = static_cast<std::size_t>(slice.tile),
               rows = static_cast<std::size_t>(slice.rows);
    std::vector<std::byte> values;
    values.reserve(rows * row_bytes);
    for (std::size_t row = tile / across * rows; row < (tile / across + 1) * rows; ++row) {
        const auto line = frame.subspan((row * across + tile % across) * row_bytes, row_bytes);
        values.insert(values.end(), line.begin(), line.end());
    }
    return values;
}

}  // namespace

void DicomPixels::add(const DicomSlice& slice, ValueSink& sink) {
    const std::string file = slice.path.string();
    if (file_->path != slice.path) {
        *file_ = File{};
        check_ratio(file, slice);
        check_gray(file, slice);
        gdcm::ImageReader reader;
        reader.SetFileName(file.c_str());
        if (!reader.Read()) {
            throw ImportError(file + ": its pixel data (7fe0,0010) cannot be read: cut or broken");
        }
        const gdcm::Image& image = reader.GetImage();
        file_->component = component_of(file, image.GetPixelFormat());
        const std::size_t needed = static_cast<std::size_t>(slice.stored_columns()) *
                                   static_cast<std::size_t>(slice.stored_rows()) *
                                   static_cast<std::size_t>(slice.frames) *
                                   component_bytes(file_->component);
        check_pixels(file, slice, image, needed);
        file_->values.resize(needed);
        if (!image.GetBuffer(file_->values.data())) {
            throw ImportError(fmt::format(
                "{}: its pixel data of transfer syntax {} (0002,0010) cannot be decoded", file,
                image.GetTransferSyntax().GetString()));
        }
        file_->path = slice.path;
    }
    const std::size_t frame_bytes = file_->values.size() / static_cast<std::size_t>(slice.frames);
    const auto frame =
        std::as_bytes(std::span(file_->values))
            .subspan(static_cast<std::size_t>(slice.frame) * frame_bytes, frame_bytes);
    if (slice.tiles_across == 1) {
        sink.add(frame, file_->component, slice.scale);
        return;
    }
    sink.add(tile_of(frame, slice, component_bytes(file_->component)), file_->component,
             slice.scale);
}

}  // namespace pxpl5::host::io

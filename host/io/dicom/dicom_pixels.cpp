// The pixels of DICOM files.
#include <fmt/format.h>
#include <gdcmBitmap.h>
#include <gdcmReader.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>

#include "host/io/dicom/dicom_file.hpp"
#include "host/io/values/file_at_work.hpp"
#include "host/io/values/header_text.hpp"

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

/// GDCM asserts on some numbers of samples, and on broken color tables.
void check_gray(const std::string& file, const DicomSlice& slice) {
    if (slice.samples != 1) {
        throw ImportError(
            fmt::format("{}: samples per pixel (0028,0002) are {}, must be 1: color is not read",
                        file, slice.samples));
    }
    if (!slice.is_gray()) {
        throw ImportError(
            fmt::format("{}: photometric interpretation (0028,0004) is '{}', must be MONOCHROME1 "
                        "or MONOCHROME2: color is not read",
                        file, shown(slice.photometric)));
    }
}

/// Broken sizes must not become gigabytes: nothing compresses so well.
void check_ratio(const std::string& file, const DicomSlice& slice) {
    constexpr std::uint64_t unsuspicious_bytes = std::uint64_t{1} << 29, max_ratio = 1000;
    const std::uint64_t pixels = static_cast<std::uint64_t>(slice.stored_columns()) *
                                 static_cast<std::uint64_t>(slice.stored_rows()) *
                                 static_cast<std::uint64_t>(slice.frames);
    const std::uint64_t has = slice.input().size_bytes();
    if (pixels > unsuspicious_bytes && pixels / max_ratio > has) {
        throw ImportError(fmt::format("{}: states {}x{}x{} pixels, but has {} bytes", file,
                                      slice.stored_columns(), slice.stored_rows(), slice.frames,
                                      has));
    }
}

using RleHeader = std::array<std::uint32_t, 16>;  ///< The number of segments, and their places.

/// A frame of RLE: the bytes of its header, and the size of all.
struct RleFrame {
    std::string header;
    std::size_t size_bytes = 0;

    void add(const gdcm::Fragment& fragment) {
        if (const gdcm::ByteValue* const value = fragment.GetByteValue()) {
            const std::size_t bytes = value->GetLength();
            header.append(value->GetPointer(), std::min(bytes, sizeof(RleHeader) - header.size()));
            size_bytes += bytes;
        }
    }
};

/// GDCM divides by the number of segments, and trusts their places.
/// Source: DICOM PS3.5, annex G.
void check_rle_header(const std::string& place, const RleFrame& frame, std::size_t value_bytes) {
    constexpr const char* remedy = ". The file is damaged";
    RleHeader header{};
    if (frame.header.size() < sizeof header) {
        throw ImportError(fmt::format("{} has {} bytes, its header needs {}{}", place,
                                      frame.size_bytes, sizeof header, remedy));
    }
    std::memcpy(header.data(), frame.header.data(), sizeof header);
    if (header[0] != value_bytes) {
        throw ImportError(fmt::format("{} has {} segments, values of {} bytes need {}{}", place,
                                      header[0], value_bytes, value_bytes, remedy));
    }
    std::size_t least = sizeof header;
    for (std::size_t segment = 1; segment <= value_bytes; ++segment) {
        if (header[segment] < least || header[segment] >= frame.size_bytes) {
            throw ImportError(fmt::format("{} has segment {} at byte {}, allowed are {} .. {}{}",
                                          place, segment, header[segment], least,
                                          frame.size_bytes - 1, remedy));
        }
        least = std::size_t{header[segment]} + 1;
    }
}

/// Checks RLE fragments: one per frame, but GDCM joins the fragments of a single frame.
void check_rle(const DicomSlice& slice, const gdcm::Bitmap& image) {
    const std::string file = slice.path.string();
    const gdcm::SequenceOfFragments* const fragments =
        image.GetDataElement().GetSequenceOfFragments();
    if (image.GetTransferSyntax() != gdcm::TransferSyntax::RLELossless || fragments == nullptr) {
        return;
    }
    const std::size_t count = fragments->GetNumberOfFragments();
    std::vector<RleFrame> frames(static_cast<std::size_t>(slice.frames));
    if (frames.size() > 1 && count != frames.size()) {
        throw ImportError(
            fmt::format("{}: its RLE pixels have {} fragments, {} frames need {}. The file is "
                        "damaged",
                        file, count, frames.size(), frames.size()));
    }
    for (std::size_t at = 0; at < count; ++at) {
        frames[frames.size() == 1 ? 0 : at].add(fragments->GetFragment(at));
    }
    for (std::size_t at = 0; at < frames.size(); ++at) {
        check_rle_header(fmt::format("{}: frame {} of its RLE pixels", file, at + 1), frames[at],
                         static_cast<std::size_t>(slice.bits) / 8);
    }
}

/// The pixels of a file. gdcm::ImageReader would also read icons, overlays, curves, color tables
/// and places, and asserts on many values of theirs.
class StoredPixels : public gdcm::Bitmap {
  public:
    StoredPixels(const DicomSlice& slice, const gdcm::File& file) {
        SetTransferSyntax(file.GetHeader().GetDataSetTransferSyntax());
        SetNumberOfDimensions(slice.frames > 1 ? 3 : 2);
        SetDimension(0, static_cast<unsigned>(slice.stored_columns()));
        SetDimension(1, static_cast<unsigned>(slice.stored_rows()));
        if (slice.frames > 1) {
            SetDimension(2, static_cast<unsigned>(slice.frames));
        }
        gdcm::PixelFormat format;
        format.SetSamplesPerPixel(1);
        format.SetBitsAllocated(static_cast<std::uint16_t>(slice.bits));
        if (slice.bits > 8) {  // GDCM's decoders assert that all bits of a byte are stored.
            format.SetBitsStored(static_cast<std::uint16_t>(slice.bits_stored));
        }
        format.SetPixelRepresentation(slice.is_signed ? 1 : 0);
        SetPixelFormat(format);
        SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
        SetNeedByteSwap(GetTransferSyntax() == gdcm::TransferSyntax::ImplicitVRBigEndianPrivateGE);
        SetDataElement(file.GetDataSet().GetDataElement(gdcm::Tag(0x7fe0, 0x0010)));
        take_raw_pixels();
        check_rle(slice, *this);
        ComputeLossyFlag();  // Takes size and bits of a compressed picture from its own header.
    }

    int bits_stored(const DicomSlice& slice) const {
        const bool states_bits = GetTransferSyntax().IsEncapsulated() &&
                                 GetTransferSyntax() != gdcm::TransferSyntax::RLELossless;
        return states_bits || slice.bits > 8 ? GetPixelFormat().GetBitsStored() : slice.bits_stored;
    }

  private:
    /// Some writers state a compression, and write none.
    void take_raw_pixels() {
        const gdcm::ByteValue* raw = GetDataElement().GetByteValue();
        if (!GetTransferSyntax().IsEncapsulated() || raw == nullptr) {
            return;
        }
        if (const std::size_t length = raw->GetLength();
            length == GetBufferLength() || length == GetBufferLength() + 1) {
            SetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
        }
    }
};

void check_pixels(const std::string& file, const DicomSlice& slice, const gdcm::Bitmap& image,
                  std::size_t needed) {
    if (const int samples = image.GetPixelFormat().GetSamplesPerPixel(); samples != 1) {
        throw ImportError(
            fmt::format("{}: its compressed pixels have {} samples, its header states 1: color is "
                        "not read",
                        file, samples));
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
        const FileAtWork at_work(file);
        const std::unique_ptr<std::istream> stream = slice.input().open();
        gdcm::Reader reader;
        reader.SetStream(*stream);
        if (!reader.Read() ||
            !reader.GetFile().GetDataSet().FindDataElement(gdcm::Tag(0x7fe0, 0x0010))) {
            throw ImportError(file + ": its pixel data (7fe0,0010) cannot be read: cut or broken");
        }
        const StoredPixels image(slice, reader.GetFile());
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
        // Bits above the stored ones may hold an overlay.
        clear_unused_bits(std::as_writable_bytes(std::span(file_->values)), file_->component,
                          image.bits_stored(slice));
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

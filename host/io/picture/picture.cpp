// The only file that includes OpenImageIO.
#include "host/io/picture/picture.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <set>
#include <system_error>

#include "host/base/part_file.hpp"
#include "host/io/picture/draw_marks.hpp"
#include "host/io/picture/multi_picture.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t head_bytes = std::size_t{1} << 16;  // Bytes of a file beside its pixels.

std::size_t bytes_of_one(const Picture& picture) {
    return 4 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
}

void check_attributes(const std::string& file, const Picture& picture) {
    if (picture.attributes.size() > max_attributes) {
        throw PictureError(fmt::format("{}: {} attributes, at most {}", file,
                                       picture.attributes.size(), max_attributes));
    }
    std::set<std::string> names;
    for (const PictureAttribute& attribute : picture.attributes) {
        const std::string& name = attribute.name;
        const bool printable =
            std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~'; });
        if (name.empty() || name.size() > max_attribute_name || !printable) {
            throw PictureError(
                fmt::format("{}: attribute '{}' must be named in 1 to {} ASCII letters", file, name,
                            max_attribute_name));
        }
        if (!names.insert(name).second) {
            throw PictureError(fmt::format("{}: attribute '{}' is there twice", file, name));
        }
    }
}

bool is_jpeg(std::string_view suffix) {
    return suffix == ".jps" || suffix == ".mpo";
}

/// Throws unless the suffix holds as many pictures as there are.
void check_count(const std::string& file, const std::string& suffix, const Picture& picture) {
    constexpr int eyes = 2;
    if (suffix == ".mpo" && picture.count != eyes) {
        throw PictureError(fmt::format("{}: {} pictures, but .mpo holds {}, one for each eye", file,
                                       picture.count, eyes));
    }
    if (picture.count < 1 || picture.count > max_animation_pictures) {
        throw PictureError(fmt::format("{}: {} pictures, must be 1 to {}", file, picture.count,
                                       max_animation_pictures));
    }
    if (picture.count > 1 && suffix != ".gif" && suffix != ".mpo") {
        throw PictureError(
            fmt::format("{}: {} pictures need an animation, which is .gif; '{}' "
                        "holds one",
                        file, picture.count, suffix));
    }
    if (picture.delay_ms < min_delay_ms || picture.delay_ms > max_delay_ms) {
        throw PictureError(fmt::format("{}: {} ms between pictures, must be {} to {}", file,
                                       picture.delay_ms, min_delay_ms, max_delay_ms));
    }
}

/// The writers of TIFF and JPEG drop attributes that they do not know.
std::string description_of(const std::string& suffix, const Picture& picture) {
    std::string text = picture.description;
    if (suffix == ".tif" || suffix == ".tiff" || is_jpeg(suffix)) {
        for (const PictureAttribute& attribute : picture.attributes) {
            text += fmt::format("{}pxpl5:{}={}", text.empty() ? "" : "\n", attribute.name,
                                attribute.value);
        }
    }
    return text;
}

void check(const fs::path& path, const Picture& picture) {
    const std::string file = path.string();
    constexpr std::array known = {".png", ".tif", ".tiff", ".exr", ".gif",
                                  ".svg", ".pdf", ".jps",  ".mpo"};
    if (std::find(known.begin(), known.end(), suffix_of(path)) == known.end()) {
        throw PictureError(
            fmt::format("{}: suffix is '{}', must be .png, .tif, .tiff, .exr, .gif, .svg, .pdf, "
                        ".jps or .mpo",
                        file, path.extension().string()));
    }
    if (picture.width < 1 || picture.height < 1 || picture.width > max_export_px ||
        picture.height > max_export_px) {
        throw PictureError(fmt::format("{}: picture of {}x{} pixels, each side must be 1 to {}",
                                       file, picture.width, picture.height, max_export_px));
    }
    check_count(file, suffix_of(path), picture);
    const std::size_t bytes = bytes_of_one(picture) * static_cast<std::size_t>(picture.count);
    if (picture.rgba.size() != bytes) {
        throw PictureError(fmt::format("{}: {} of {}x{} pixels of RGBA need {} bytes, got {}", file,
                                       picture.count, picture.width, picture.height, bytes,
                                       picture.rgba.size()));
    }
    check_attributes(file, picture);
    if (const std::size_t text = description_of(suffix_of(path), picture).size();
        is_jpeg(suffix_of(path)) && text > max_jpeg_text) {
        throw PictureError(
            fmt::format("{}: description and attributes have {} bytes, but JPEG has room for {}. "
                        "Write a .png",
                        file, text, max_jpeg_text));
    }
    if (const std::string wrong = wrong_place(path); !wrong.empty()) {
        throw PictureError(wrong);
    }
}

bool is_opaque(std::span<const std::uint8_t> rgba) {
    for (std::size_t index = 3; index < rgba.size(); index += 4) {
        if (rgba[index] != 255) {
            return false;
        }
    }
    return true;
}

OIIO::ImageSpec spec_of(const std::string& suffix, const Picture& picture, int channels) {
    // OpenEXR has no 8-bit values; half holds each of the 256 apart.
    OIIO::ImageSpec spec(picture.width, picture.height, channels,
                         suffix == ".exr" ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8);
    const std::string description = description_of(suffix, picture);
    if (!description.empty() || !is_jpeg(suffix)) {  // OpenImageIO aborts at an empty one in IPTC.
        spec.attribute("ImageDescription", description);
    }
    spec.attribute("Software", "pxpl5");
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("png:compressionLevel", 4);  // Half the time of 6 for 5 % more bytes.
    if (is_jpeg(suffix)) {
        spec.attribute("Compression", "jpeg:95");
        spec.attribute("jpeg:subsampling", "4:4:4");  // Edges of both eyes stay in their places.
    }
    // The prefix keeps them apart from names that mean something to a writer, as "compression".
    for (const PictureAttribute& attribute : picture.attributes) {
        spec.attribute("pxpl5:" + attribute.name, attribute.value);
    }
    // GIF's writer cuts the hundredths of a second that it computes: half a one more is safe.
    const int hundredths = (picture.delay_ms + 5) / 10;
    spec.attribute("FramesPerSecond", static_cast<float>(100.0 / (hundredths + 0.5)));
    return spec;
}

/// The picture with its marks, or the picture itself.
class MarkedPictures {
  public:
    explicit MarkedPictures(const Picture& picture) : picture_(picture) {
        if (!picture.marks.empty()) {
            layer_ = draw_marks(picture.marks, picture.width, picture.height);
        }
    }

    /// Holds until the next call.
    std::span<const std::uint8_t> get(int index) {
        const std::size_t bytes = bytes_of_one(picture_);
        const auto rgba = picture_.rgba.subspan(static_cast<std::size_t>(index) * bytes, bytes);
        if (!layer_) {
            return rgba;
        }
        marked_.assign(rgba.begin(), rgba.end());
        lay_over(*layer_, marked_);
        return marked_;
    }

  private:
    const Picture& picture_;
    std::optional<MarkLayer> layer_;
    std::vector<std::uint8_t> marked_;
};

using Proxy = OIIO::Filesystem::IOProxy;
using Memory = OIIO::Filesystem::IOVecOutput;

/// Writes into an open file. OpenImageIO's own proxy does not see that the last bytes of a PNG or
/// OpenEXR file have no room: they wait in a buffer until the file is closed.
class OpenFile final : public Proxy {
  public:
    explicit OpenFile(const PartFile& part)
        : Proxy(part.path().string(), Proxy::Mode::Write), file_(part.stream()) {}

    const char* proxytype() const override { return "open file"; }
    bool seek(int64_t offset) override {
        m_pos = offset;
        return note(fseeko(file_, offset, SEEK_SET) == 0);  // It may write what is buffered.
    }
    size_t write(const void* bytes, size_t size) override {
        const std::size_t written = std::fwrite(bytes, 1, size, file_);
        m_pos += static_cast<int64_t>(written);
        note(written == size);
        return written;
    }

    int failure = 0;  ///< The first errno: OpenEXR's writer hides some failures.

  private:
    bool note(bool is_done) {
        failure = is_done || failure != 0 ? failure : errno;
        return is_done;
    }

    std::FILE* file_;
};

/// Writes to the file `name`, or to `proxy` if there is one. Throws PictureError with
/// OpenImageIO's reason.
void encode(const std::string& name, Proxy* proxy, const Picture& picture) {
    MarkedPictures pictures(picture);
    const std::string suffix = suffix_of(name);
    const bool has_alpha = suffix != ".gif" && !is_jpeg(suffix) && !is_opaque(picture.rgba);
    const int channels = has_alpha ? 4 : 3;
    const OIIO::ImageSpec spec = spec_of(suffix, picture, channels);
    OIIO::attribute("threads", 1);
    const std::unique_ptr<OIIO::ImageOutput> output =
        OIIO::ImageOutput::create(is_jpeg(suffix) ? "jpeg" : name, proxy);
    if (!output) {
        throw PictureError(OIIO::geterror());
    }
    for (int index = 0; index < picture.count; ++index) {
        const auto mode =
            index == 0 ? OIIO::ImageOutput::Create : OIIO::ImageOutput::AppendSubimage;
        const bool written = output->open(name, spec, mode) &&
                             output->write_image(OIIO::TypeDesc::UINT8, pictures.get(index).data(),
                                                 4, OIIO::AutoStride, OIIO::AutoStride);
        // Only has_error() reports a PNG for which the disk has no room.
        if (!written || output->has_error()) {
            throw PictureError(output->geterror());
        }
    }
    if (!output->close() || output->has_error()) {
        throw PictureError(output->geterror());
    }
}

/// The JPEG file of one of the pictures. In memory: where a disk is full, libjpeg ends the process.
std::vector<unsigned char> jpeg_of(const Picture& pictures, std::size_t index) {
    Picture one = pictures;
    const std::size_t bytes = bytes_of_one(pictures);
    one.rgba = pictures.rgba.subspan(index * bytes, bytes);
    one.count = 1;
    std::vector<unsigned char> jpeg;
    Memory memory(jpeg);
    encode("eye.jps", &memory, one);
    return jpeg;
}

/// The separation that the attributes state; 0 if they state none.
double separation_mm(const Picture& picture) {
    const auto stated =
        std::ranges::find(picture.attributes, separation_attribute, &PictureAttribute::name);
    constexpr double most_mm = 1e6;
    return stated == picture.attributes.end()
               ? 0
               : std::clamp(std::strtod(stated->value.c_str(), nullptr), 0.0, most_mm);
}

/// The first line of what OpenImageIO says: a full disk makes it say the same for each block.
std::string first_line(const std::string& text) {
    return text.substr(0, text.find('\n'));
}

/// Throws PictureError if the end of the file had no room: libtiff writes the directory when it
/// closes the file, and OpenImageIO hides a failure of this. A file that is cut off ends where the
/// disk was full, so it cannot grow.
void check_end(const PartFile& part) {
    constexpr std::uint64_t growth = std::uint64_t{1} << 16;  // More than a block of the disk.
    const int fd = fileno(part.stream());
    struct stat facts {};
    const bool is_known = fstat(fd, &facts) == 0;
    const std::string lack =
        is_known ? part.lack_of_room(static_cast<std::uint64_t>(facts.st_size) + growth) : "";
    if (!lack.empty()) {
        throw PictureError(lack);
    }
    if (!is_known || ftruncate(fd, facts.st_size) != 0) {
        throw PictureError(std::generic_category().message(errno));
    }
}

/// encode() to the file. Says what the system says where the disk has no room for the picture,
/// since the writers' own words for it differ and do not name it.
void encode_to(const PartFile& part, const Picture& picture) {
    const std::string suffix = suffix_of(part.path());
    const bool is_tiff = suffix == ".tif" || suffix == ".tiff";  // It spoils what goes by a proxy.
    OpenFile file(part);
    try {
        encode(part.path().string(), is_tiff ? nullptr : &file, picture);
    } catch (const PictureError& error) {
        const std::size_t raw_bytes =
            bytes_of_one(picture) * static_cast<std::size_t>(picture.count) + head_bytes;
        const std::string lack = part.lack_of_room(raw_bytes);
        throw PictureError(lack.empty() ? first_line(error.what()) : lack);
    }
    if (file.failure != 0) {
        throw PictureError(std::generic_category().message(file.failure));
    }
    if (is_tiff) {
        check_end(part);
    }
}

/// Why the picture cannot be written; empty once it is.
std::string written(const fs::path& path, const Picture& picture) {
    try {
        PartFile part(path);
        if (const std::string suffix = suffix_of(path); suffix == ".svg" || suffix == ".pdf") {
            const auto format = suffix == ".svg" ? DocumentFormat::svg : DocumentFormat::pdf;
            part.write(draw_document(format, {picture.width, picture.height, picture.rgba,
                                              picture.marks, picture.description}));
        } else if (suffix == ".gif") {
            // Its writer does not report a full disk; TIFF's, on the other hand, spoils what it
            // writes to memory.
            std::vector<unsigned char> bytes;
            Memory memory(bytes);
            encode(part.path().string(), &memory, picture);
            part.write_raw(std::span<const unsigned char>(bytes));
        } else if (suffix == ".jps") {
            part.write_raw(std::span<const unsigned char>(jpeg_of(picture, 0)));
        } else if (suffix == ".mpo") {
            const std::vector<unsigned char> left = jpeg_of(picture, 0),
                                             right = jpeg_of(picture, 1);
            const std::vector<std::uint8_t> file =
                multi_picture({left, right}, separation_mm(picture));
            part.write_raw(std::span<const unsigned char>(file));
        } else if (!part.has_failed()) {
            encode_to(part, picture);
        }
        return part.keep();
    } catch (const PictureError& error) {
        return error.what();
    } catch (const MarkError& error) {
        return error.what();
    }
}

}  // namespace

void write_picture(const std::string& path, const Picture& picture) {
    check(path, picture);
    if (const std::string failure = written(path, picture); !failure.empty()) {
        throw PictureError(fmt::format("{}: cannot be written: {}", path, failure));
    }
}

}  // namespace pxpl5::host::io

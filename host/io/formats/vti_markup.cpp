#include "host/io/formats/vti_markup.hpp"

#include <expat.h>
#include <fmt/format.h>

#include <array>
#include <fstream>
#include <memory>
#include <string_view>
#include <type_traits>

#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 16;
constexpr std::int64_t most_tag_bytes = std::int64_t{1} << 20;
constexpr std::size_t most_names = 8;

class VtiParser {
  public:
    explicit VtiParser(const std::filesystem::path& path)
        : file_(path.string()),
          stream_(path, std::ios::binary),
          parser_(XML_ParserCreate(nullptr), XML_ParserFree) {
        if (!stream_ || !parser_) {
            throw ImportError(file_ + ": cannot be opened");
        }
        XML_SetUserData(parser_.get(), this);
        XML_SetElementHandler(
            parser_.get(),
            [](void* self, const XML_Char* name, const XML_Char** words) {
                static_cast<VtiParser*>(self)->begin(name, words);
            },
            [](void* self, const XML_Char* name) { static_cast<VtiParser*>(self)->end(name); });
        // Entities could make a small file large.
        XML_SetStartDoctypeDeclHandler(
            parser_.get(), [](void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
                static_cast<VtiParser*>(self)->stop("has a document type, which is not read");
            });
    }

    VtiMarkup run() {
        std::array<char, chunk_bytes> chunk{};
        std::int64_t fed = 0;
        while (!is_done_) {
            stream_.read(chunk.data(), chunk.size());
            const auto count = static_cast<int>(stream_.gcount());
            fed += count;
            const XML_Status status = XML_Parse(parser_.get(), chunk.data(), count, count == 0);
            if (!refusal_.empty()) {
                throw ImportError(file_ + ": " + refusal_);
            }
            if (!is_done_ && status != XML_STATUS_OK) {
                throw ImportError(fmt::format("{}: is no XML at line {}: {}", file_,
                                              XML_GetCurrentLineNumber(parser_.get()),
                                              XML_ErrorString(XML_GetErrorCode(parser_.get()))));
            }
            if (!is_done_ && fed - XML_GetCurrentByteIndex(parser_.get()) > most_tag_bytes) {
                throw ImportError(fmt::format("{}: has a tag of more than {} bytes at line {}",
                                              file_, most_tag_bytes,
                                              XML_GetCurrentLineNumber(parser_.get())));
            }
            if (count == 0) {
                break;
            }
        }
        if (!out_.has_array) {
            refuse_arrays();
        }
        if (!is_done_) {
            throw ImportError(file_ + ": its array is 'appended', but it has no AppendedData");
        }
        return std::move(out_);
    }

  private:
    void stop(std::string reason) {
        refusal_ = std::move(reason);
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    void begin(std::string_view name, const XML_Char** words) {
        TagAttributes attributes;
        for (; words[0] != nullptr; words += 2) {
            attributes[words[0]] = words[1];
        }
        if (!is_vtk_ && name != "VTKFile") {
            stop(fmt::format("begins with <{}>, must be <VTKFile>", shown(name)));
        } else if (name == "VTKFile") {
            is_vtk_ = true;
            const std::string kind = attributes["type"];
            out_.file = std::move(attributes);
            if (kind != "ImageData") {
                stop(fmt::format("is VTK's '{}', must be ImageData", shown(kind)));
            }
        } else if (name == "ImageData") {
            out_.image = std::move(attributes);
        } else if (name == "Piece" && out_.piece.empty()) {
            out_.piece = std::move(attributes);
        } else if (name == "PointData") {
            is_in_points_ = true;
            out_.point_data = std::move(attributes);
        } else if (name == "DataArray" && is_in_points_ && !out_.has_array) {
            take_array(std::move(attributes));
        } else if (name == "AppendedData") {
            out_.appended = std::move(attributes);
            reach_values();
        }
    }

    void end(std::string_view name) { is_in_points_ = is_in_points_ && name != "PointData"; }

    void take_array(TagAttributes attributes) {
        const auto wanted = out_.point_data.find("Scalars");
        const std::string& name = attributes["Name"];
        if (wanted != out_.point_data.end() && wanted->second != name) {
            if (count_ < most_names) {
                names_ += (count_ == 0 ? "" : ", ") + shown(name);
            }
            ++count_;
            return;
        }
        out_.has_array = true;
        out_.array = std::move(attributes);
        const auto format = out_.array.find("format");
        if (format == out_.array.end() || format->second != "appended") {
            reach_values();
        }
    }

    void reach_values() {
        is_done_ = true;
        out_.values_at = static_cast<std::uint64_t>(XML_GetCurrentByteIndex(parser_.get())) +
                         static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
        XML_StopParser(parser_.get(), XML_FALSE);
    }

    [[noreturn]] void refuse_arrays() const {
        if (count_ == 0) {
            throw ImportError(file_ + ": has no array of PointData; CellData are not read");
        }
        throw ImportError(fmt::format(
            "{}: Scalars is '{}', but the arrays of PointData are {}{}", file_,
            shown(out_.point_data.at("Scalars")), names_,
            count_ > most_names ? fmt::format(" and {} more", count_ - most_names) : ""));
    }

    std::string file_;
    std::ifstream stream_;
    std::unique_ptr<std::remove_pointer_t<XML_Parser>, void (*)(XML_Parser)> parser_;
    VtiMarkup out_;
    std::string refusal_;
    std::string names_;      ///< The first arrays that are not the wanted one.
    std::size_t count_ = 0;  ///< Arrays that are not the wanted one.
    bool is_vtk_ = false, is_in_points_ = false, is_done_ = false;
};

}  // namespace

VtiMarkup read_vti_markup(const std::filesystem::path& path) {
    return VtiParser(path).run();
}

}  // namespace pxpl5::host::io

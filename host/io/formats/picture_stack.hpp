// Slices as pictures: a TIFF of many pages, or a folder of numbered PNG, TIFF, JPEG or BMP files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/io/values/component.hpp"
#include "host/io/values/import_request.hpp"
#include "host/io/values/value_sink.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t max_pages = 4096;

/// "PNG", "TIFF", "JPEG" or "BMP", by the suffix of `path`; empty if it is that of no picture that
/// is read.
std::string picture_kind(const std::filesystem::path& path);
bool is_picture(const std::filesystem::path& path);

/// Keeps PNG and TIFF pictures; without any, BMP pictures; without any, JPEG pictures: a preview
/// beside the slices is no slice.
void keep_one_kind(std::vector<std::filesystem::path>& pictures);

/// Puts "s2" before "s10": runs of digits compare as numbers.
bool is_naturally_before(const std::string& a, const std::string& b);

/// The pages of picture files, which have one size and type. The files are read twice, first for
/// the size of the volume: they may change in between, when another program still writes them.
class PicturePages {
  public:
    struct Page {
        int columns = 0, rows = 0;
        Component component = Component::uint8;
        friend bool operator==(const Page&, const Page&) = default;
    };

    /// Counts the pages of the files.
    ///
    /// source   File or folder, for error texts.
    /// Throws   ImportError: no page or too many, color, pictures that differ.
    PicturePages(const std::string& source, const std::vector<std::filesystem::path>& files);

    const Page& page() const { return page_; }
    std::size_t count() const;

    /// Adds the values of all pages. Throws ImportError that names the file if it is broken, or if
    /// its pages are not the counted ones.
    void read(ValueSink& sink) const;

  private:
    struct File {
        std::filesystem::path path;
        int pages = 0;
    };
    void read_file(const File& file, ValueSink& sink) const;

    Page page_;
    std::vector<File> files_;
};

/// Reads pictures of one size and type as slices, in this order; a file may hold several pages.
///
/// source   File or folder, for error texts.
/// Throws   ImportError: no spacing asked for, color, pictures that differ, a broken file.
Volume read_pictures(const std::string& source, const std::vector<std::filesystem::path>& files,
                     const ImportRequest& request);

}  // namespace pxpl5::host::io

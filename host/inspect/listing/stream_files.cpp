#include "host/inspect/listing/stream_files.hpp"

#include <fmt/format.h>

#include <system_error>

#include "host/base/error.hpp"
#include "host/base/text_output.hpp"
#include "host/inspect/listing/region_listing.hpp"
#include "host/inspect/record/region_walk.hpp"
#include "isa/disassemble.hpp"
#include "isa/instruction_counts.hpp"
#include "isa/program.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace fs = std::filesystem;
using Part = renderer::RegionPlan::Part;
using Kind = PartKind;

/// A file under way.
struct File {
    std::string name, text;
};

/// Whether a stream may go on behind these words: no branch, whose addresses count from its begin,
/// and no end.
bool may_be_followed(renderer::Words words) {
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        if (isa::decode(words[at])->op == isa::Op::eor) {
            return false;
        }
    }
    return isa::runs_straight(words);
}

/// The files of one region.
class RegionFiles {
  public:
    RegionFiles(const RecordedFrame& frame, const RecordedRegion& region)
        : region_(region), primitives_(primitives_of(frame, region)) {}

    void add(std::size_t index) {
        const Part& part = region_.plan.parts[index];
        const bool straight = may_be_followed(part.segment.words);
        if (files_.empty() || part.kind != Kind::segment || !straight || !may_go_on_) {
            const std::string kind =
                part.kind == Kind::segment ? "" : fmt::format(".{}", kind_name(part.kind));
            files_.push_back(
                {fmt::format("region-{}.{}{}.pxasm", region_.place.number, files_.size(), kind),
                 ""});
        }
        may_go_on_ = part.kind == Kind::segment && straight;
        put_words(index);
    }

    const std::vector<File>& files() const { return files_; }

  private:
    void put_words(std::size_t index) {
        const Part& part = region_.plan.parts[index];
        const renderer::Words words = part.segment.words;
        std::string& text = files_.back().text;
        text += part_heading(part);
        std::size_t from = 0;
        for (const Primitive& primitive : primitives_) {
            if (primitive.part == index) {
                text += isa::disassemble(words.subspan(from, primitive.first_word - from));
                text += primitive_heading(primitive, region_.plan);
                from = primitive.first_word;
            }
        }
        text += isa::disassemble(words.subspan(from));
    }

    const RecordedRegion& region_;
    std::vector<Primitive> primitives_;
    std::vector<File> files_;
    bool may_go_on_ = false;
};

}  // namespace

StreamFiles write_streams(const RecordedRun& run, const Selection& selection,
                          const fs::path& folder) {
    StreamFiles written;
    for (const std::uint32_t number : run.frames()) {
        if (!selection.has_frame(number)) {
            continue;
        }
        const fs::path place = folder / fmt::format("frame-{}", number);
        std::error_code error;
        fs::create_directories(place, error);
        if (error) {
            throw RequestError(ExitCode::failed,
                               fmt::format("cannot make {}: {}", place.string(), error.message()));
        }
        const RecordedFrame frame = run.frame(number);
        for (const RecordedRegion* region : selected_regions(frame, selection)) {
            RegionFiles files(frame, *region);
            for (std::size_t part = 0; part < region->plan.parts.size(); ++part) {
                if (has_part(selection, region->plan.parts[part])) {
                    files.add(part);
                }
            }
            for (const File& file : files.files()) {
                TextOutput output((place / file.name).string());
                output.put(file.text);
                output.finish();
            }
            written.files += files.files().size();
            ++written.regions;
        }
    }
    return written;
}

}  // namespace pxpl5::host::inspect

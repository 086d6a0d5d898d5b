// A recorded run on disk whose messages an input changes.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "ringbus/trace/trace_file.hpp"
#include "tests/fuzz/edits.hpp"
#include "tests/fuzz/scratch.hpp"

namespace pxpl5::fuzz {

/// The run of a simulated machine that drew a sphere.
class RecordedFiles {
  public:
    /// samples  Frames of the picture, 1 or 4.
    RecordedFiles(const std::filesystem::path& folder, int samples);

    /// Changes the messages that the input names, if they stay valid, and writes their traces.
    /// Traces that an earlier input changed are restored.
    void edit(Bytes& bytes);

    /// The run folder.
    std::string path() const { return folder_.string(); }

  private:
    struct Node {
        bus::trace::Info info;
        std::vector<bus::Message> messages;
    };
    void write(std::size_t node, const std::vector<bus::Message>& messages) const;

    std::filesystem::path folder_;
    std::vector<Node> nodes_;
    std::size_t messages_ = 0;
    std::set<std::size_t> changed_;  ///< Nodes whose files differ from the recording.
};

}  // namespace pxpl5::fuzz

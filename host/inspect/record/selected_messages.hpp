// The messages of a run that a selection names, in total order.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/record/selection.hpp"

namespace pxpl5::host::inspect {

/// Where a message lies.
struct MessageRef {
    const NodeTrace* node = nullptr;  ///< Whose trace: the receiver.
    std::size_t entry = 0;

    const bus::trace::Entry& at() const { return node->entries[entry]; }
    const bus::schema::Header& header() const { return at().header; }
    bus::Message load() const { return node->load(at()); }
};

/// Messages of the selected kinds, by logical time, then source, then sequence. --frame selects
/// messages of these frames; --gp and --renderer select messages from or to these nodes.
std::vector<MessageRef> select_messages(const RecordedRun& run, const Selection& selection);

/// "kind", "bytes" and so on of one line of `trace dump`.
std::string message_heading();
/// start_ns  Wall time that counts as 0.
std::string message_line(const RecordedRun& run, const MessageRef& message, std::uint64_t start_ns);

/// Wall time of the first receipt in the run; 0 if nothing was received.
std::uint64_t start_of(const RecordedRun& run);

}  // namespace pxpl5::host::inspect

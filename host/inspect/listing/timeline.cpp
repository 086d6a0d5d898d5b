#include "host/inspect/listing/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/inspect/record/message_text.hpp"
#include "host/inspect/record/selected_messages.hpp"

namespace pxpl5::host::inspect {

namespace {

namespace schema = bus::schema;
using bus::Body;
using Json = nlohmann::ordered_json;

constexpr double ns_per_us = 1e3;
constexpr std::int64_t ns_per_cycle = 25;  ///< At 40 MHz.
constexpr int events_per_message = 3;      ///< A slice, and both ends of an arrow.

enum Track : int { receives = 1, draws = 2, modelled = 3 };

/// Milestones of one frame, wall time.
struct FrameTimes {
    std::optional<std::uint64_t> asked_ns, done_ns;  ///< DrawFrame at GP 0, FrameDone at the host.
    std::map<std::uint32_t, std::uint64_t> fed_ns;   ///< Last RegionPrograms, by Renderer.
    std::map<std::uint32_t, std::vector<MessageRef>> pixels;  ///< By Renderer, in order of receipt.
};

class Timeline {
  public:
    Timeline(const RecordedRun& run, std::uint64_t max_events, TextOutput& output)
        : run_(run), start_ns_(start_of(run)), left_(max_events), output_(output) {}

    TimelineCounts put(const Selection& selection) {
        output_.put("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n");
        put_names();
        std::vector<MessageRef> messages = select_messages(run_, selection);
        std::ranges::sort(messages, {}, [](const MessageRef& m) { return m.at().wall_ns; });
        for (const MessageRef& message : messages) {
            note(message);
        }
        put_frames();
        put_messages(messages);
        const Json about{
            {"tool", "pxpl5 trace export --chrome"},
            {"events", counts_.events},
            {"messages_left_out", counts_.messages_left_out},
            {"note", counts_.messages_left_out == 0
                         ? "everything selected is here"
                         : "the newest messages are left out: --events allows more, --frame and "
                           "--kind select fewer"}};
        output_.put("\n],\"otherData\":" + about.dump() + "}\n");
        return counts_;
    }

  private:
    /// Whole nanoseconds since the start: sums of lengths stay exact, so that slices which follow
    /// each other do not overlap.
    std::int64_t since_start(std::uint64_t wall_ns) const {
        return static_cast<std::int64_t>(wall_ns - start_ns_);
    }
    static double us(std::int64_t ns) { return static_cast<double>(ns) / ns_per_us; }
    /// Perfetto takes process 0 for the idle process.
    static int process_of(bus::NodeId node) { return static_cast<int>(node) + 1; }

    void put_event(const Json& event) {
        output_.put(first_ ? "" : ",\n");
        output_.put(event.dump(-1, ' ', false, Json::error_handler_t::replace));
        first_ = false;
    }
    /// An event that counts.
    void put_counted(const Json& event) {
        put_event(event);
        ++counts_.events;
        left_ -= left_ == 0 ? 0 : 1;
    }

    void put_names() {
        for (const auto& [id, node] : run_.nodes()) {
            const auto put = [&](const char* what, int tid, const Json& args) {
                put_event({{"ph", "M"},
                           {"pid", process_of(id)},
                           {"tid", tid},
                           {"name", what},
                           {"args", args}});
            };
            put("process_name", 0, {{"name", run_.node_name(id)}});
            put("process_sort_index", 0, {{"sort_index", id}});
            put("thread_name", receives, {{"name", "receives"}});
            if (node.info.role == schema::Role::renderer) {
                put("thread_name", draws, {{"name", "draws"}});
                put("thread_name", modelled, {{"name", "pixel processors (modelled)"}});
            }
        }
    }

    /// Remembers what a message tells of its frame.
    void note(const MessageRef& ref) {
        if (!bus::is_of_frame(ref.at().kind())) {
            return;
        }
        const bus::Message message = ref.load();
        FrameTimes& frame = frames_[*frame_of(message)];
        const std::uint64_t wall_ns = ref.at().wall_ns;
        if (ref.at().kind() == Body::DrawFrame && !frame.asked_ns) {
            frame.asked_ns = wall_ns;
        } else if (ref.at().kind() == Body::FrameDone) {
            frame.done_ns = wall_ns;
        } else if (ref.at().kind() == Body::RegionPrograms) {
            frame.fed_ns[ref.node->info.index] = wall_ns;
        } else if (const auto* pixels = message.as<schema::RegionPixels>()) {
            frame.pixels[pixels->renderer()].push_back(ref);
        }
    }

    void put_frames() {
        for (const auto& [number, frame] : frames_) {
            const std::string name = fmt::format("frame {}", number);
            if (frame.asked_ns && frame.done_ns) {
                put_edge("b", number, name, since_start(*frame.asked_ns));
                put_edge("e", number, name, since_start(*frame.done_ns));
            }
            for (const auto& [renderer, pixels] : frame.pixels) {
                const auto fed = frame.fed_ns.find(renderer);
                const NodeTrace* node = run_.find(schema::Role::renderer, renderer);
                if (fed != frame.fed_ns.end() && node != nullptr) {
                    put_drawing(name, node->info.node, fed->second, pixels);
                }
            }
        }
    }

    void put_edge(const char* phase, std::uint32_t number, const std::string& name,
                  std::int64_t at_ns) {
        put_counted({{"ph", phase},
                     {"cat", "frame"},
                     {"id", number},
                     {"pid", process_of(bus::host_id)},
                     {"tid", receives},
                     {"name", name},
                     {"ts", us(at_ns)}});
    }

    void put_slice(bus::NodeId node, Track track, const std::string& name, std::int64_t from_ns,
                   std::int64_t length_ns, const Json& args) {
        put_counted({{"ph", "X"},
                     {"cat", track == receives ? "message" : "drawing"},
                     {"pid", process_of(node)},
                     {"tid", static_cast<int>(track)},
                     {"name", name},
                     {"ts", us(from_ns)},
                     {"dur", us(length_ns)},
                     {"args", args}});
    }

    void put_drawing(const std::string& name, bus::NodeId node, std::uint64_t fed_wall_ns,
                     const std::vector<MessageRef>& pixels) {
        // A Renderer that is fed ahead begins a frame when the frame before is drawn.
        std::int64_t& drawn_ns = drawn_ns_[node];
        const std::int64_t from_ns = std::max(since_start(fed_wall_ns), drawn_ns);
        drawn_ns = std::max(from_ns, since_start(pixels.back().at().wall_ns));
        put_slice(node, draws, name, from_ns, drawn_ns - from_ns, Json::object());
        std::int64_t& free_ns = modelled_free_ns_[node];
        free_ns = std::max(free_ns, from_ns);
        for (const MessageRef& part : pixels) {
            const bus::Message message = part.load();
            for (const schema::RegionTile* tile : *message.as<schema::RegionPixels>()->tiles()) {
                put_region(name, node, *tile, free_ns);
            }
        }
    }

    void put_region(const std::string& name, bus::NodeId node, const schema::RegionTile& tile,
                    std::int64_t& free_ns) {
        const std::int64_t length_ns = static_cast<std::int64_t>(tile.cycles()) * ns_per_cycle;
        put_slice(node, modelled, fmt::format("{} region {}", name, tile.region()), free_ns,
                  length_ns, {{"cycles", tile.cycles()}, {"instructions", tile.instructions()}});
        free_ns += length_ns;
    }

    void put_messages(const std::vector<MessageRef>& messages) {
        std::map<bus::NodeId, std::int64_t> next_ns;
        std::vector<std::int64_t> lengths_ns(messages.size(), max_slice_ns);
        for (std::size_t i = messages.size(); i-- > 0;) {
            const std::int64_t at_ns = since_start(messages[i].at().wall_ns);
            const auto [next, is_last] = next_ns.try_emplace(messages[i].node->info.node, at_ns);
            if (!is_last) {
                lengths_ns[i] = std::min(max_slice_ns, next->second - at_ns);
                next->second = at_ns;
            }
        }
        for (std::size_t i = 0; i < messages.size(); ++i) {
            if (left_ < events_per_message) {
                counts_.messages_left_out = messages.size() - i;
                return;
            }
            put_message(messages[i], lengths_ns[i]);
        }
    }

    void put_message(const MessageRef& message, std::int64_t length_ns) {
        const schema::Header& header = message.header();
        const std::int64_t at_ns = since_start(message.at().wall_ns);
        put_slice(message.node->info.node, receives, bus::kind_name(message.at().kind()), at_ns,
                  length_ns,
                  {{"from", run_.node_name(header.source())},
                   {"clock", header.clock()},
                   {"sequence", header.sequence()},
                   {"bytes", header.body_bytes()},
                   {"ring_channel", header.channel()},
                   {"modelled_ring_ns", header.arrival_ns() - header.departure_ns()},
                   {"what", describe(message.load())}});
        // What the sender had received before, among the messages that are here.
        const auto source = received_.find(header.source());
        if (source != received_.end()) {
            auto cause = source->second.lower_bound(header.clock());
            if (cause != source->second.begin()) {
                put_arrow(header.source(), std::prev(cause)->second, message.node->info.node,
                          at_ns);
            }
        }
        received_[message.node->info.node][header.clock()] = at_ns;
    }

    void put_arrow(bus::NodeId from, std::int64_t from_ns, bus::NodeId to, std::int64_t to_ns) {
        if (from_ns > to_ns) {
            return;  // Clocks of two computers disagree: no arrow is better than a wrong one.
        }
        const auto put = [&](const char* phase, bus::NodeId node, std::int64_t at_ns) {
            Json event{{"ph", phase},
                       {"cat", "message"},
                       {"id", arrows_},
                       {"pid", process_of(node)},
                       {"tid", static_cast<int>(receives)},
                       {"name", "leads to"},
                       {"ts", us(at_ns)}};
            if (*phase == 'f') {
                event["bp"] = "e";
            }
            put_counted(event);
        };
        ++arrows_;
        put("s", from, from_ns);
        put("f", to, to_ns);
    }

    const RecordedRun& run_;
    std::uint64_t start_ns_, left_, arrows_ = 0;
    TextOutput& output_;
    bool first_ = true;
    TimelineCounts counts_;
    std::map<std::uint32_t, FrameTimes> frames_;
    std::map<bus::NodeId, std::int64_t> drawn_ns_, modelled_free_ns_;        ///< Ends of slices.
    std::map<bus::NodeId, std::map<std::uint64_t, std::int64_t>> received_;  ///< Time by clock.
};

}  // namespace

TimelineCounts put_timeline(const RecordedRun& run, const Selection& selection,
                            std::uint64_t max_events, TextOutput& output) {
    return Timeline(run, max_events, output).put(selection);
}

}  // namespace pxpl5::host::inspect

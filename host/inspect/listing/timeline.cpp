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
constexpr double cycles_per_us = 40;
constexpr int events_per_message = 3;  ///< A slice, and both ends of an arrow.

enum Track : int { receives = 1, draws = 2, modelled = 3 };

/// Milestones of one frame, wall time.
struct FrameTimes {
    std::optional<std::uint64_t> asked_ns, done_ns;  ///< DrawFrame at GP 0, FrameDone at the host.
    std::map<std::uint32_t, std::uint64_t> fed_ns;   ///< Last RegionPrograms, by Renderer.
    std::map<std::uint32_t, MessageRef> pixels;      ///< By Renderer.
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
    double us(std::uint64_t wall_ns) const {
        return static_cast<double>(static_cast<std::int64_t>(wall_ns - start_ns_)) / ns_per_us;
    }

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
                put_event({{"ph", "M"}, {"pid", id}, {"tid", tid}, {"name", what}, {"args", args}});
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
            frame.pixels[pixels->renderer()] = ref;
        }
    }

    void put_frames() {
        for (const auto& [number, frame] : frames_) {
            const std::string name = fmt::format("frame {}", number);
            if (frame.asked_ns && frame.done_ns) {
                put_edge("b", number, name, us(*frame.asked_ns));
                put_edge("e", number, name, us(*frame.done_ns));
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

    void put_edge(const char* phase, std::uint32_t number, const std::string& name, double at_us) {
        put_counted({{"ph", phase},
                     {"cat", "frame"},
                     {"id", number},
                     {"pid", bus::host_id},
                     {"tid", receives},
                     {"name", name},
                     {"ts", at_us}});
    }

    void put_slice(bus::NodeId node, Track track, const std::string& name, double from_us,
                   double length_us, const Json& args) {
        put_counted({{"ph", "X"},
                     {"cat", track == receives ? "message" : "drawing"},
                     {"pid", node},
                     {"tid", static_cast<int>(track)},
                     {"name", name},
                     {"ts", from_us},
                     {"dur", length_us},
                     {"args", args}});
    }

    void put_drawing(const std::string& name, bus::NodeId node, std::uint64_t fed_ns,
                     const MessageRef& pixels) {
        const double from_us = us(fed_ns);
        put_slice(node, draws, name, from_us, std::max(0.0, us(pixels.at().wall_ns) - from_us),
                  Json::object());
        double& free_us = modelled_free_us_[node];
        free_us = std::max(free_us, from_us);
        const bus::Message message = pixels.load();
        for (const schema::RegionTile* tile : *message.as<schema::RegionPixels>()->tiles()) {
            const double length_us = static_cast<double>(tile->cycles()) / cycles_per_us;
            put_slice(node, modelled, fmt::format("{} region {}", name, tile->region()), free_us,
                      length_us,
                      {{"cycles", tile->cycles()}, {"instructions", tile->instructions()}});
            free_us += length_us;
        }
    }

    void put_messages(const std::vector<MessageRef>& messages) {
        std::map<bus::NodeId, std::uint64_t> next_ns;
        std::vector<double> lengths_us(messages.size(), max_slice_us);
        for (std::size_t i = messages.size(); i-- > 0;) {
            const std::uint64_t at_ns = messages[i].at().wall_ns;
            const auto [next, is_last] = next_ns.try_emplace(messages[i].node->info.node, at_ns);
            if (!is_last) {
                lengths_us[i] = std::min(max_slice_us, us(next->second) - us(at_ns));
                next->second = at_ns;
            }
        }
        for (std::size_t i = 0; i < messages.size(); ++i) {
            if (left_ < events_per_message) {
                counts_.messages_left_out = messages.size() - i;
                return;
            }
            put_message(messages[i], lengths_us[i]);
        }
    }

    void put_message(const MessageRef& message, double length_us) {
        const schema::Header& header = message.header();
        const double at_us = us(message.at().wall_ns);
        put_slice(message.node->info.node, receives, bus::kind_name(message.at().kind()), at_us,
                  length_us,
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
                          at_us);
            }
        }
        received_[message.node->info.node][header.clock()] = at_us;
    }

    void put_arrow(bus::NodeId from, double from_us, bus::NodeId to, double to_us) {
        if (from_us > to_us) {
            return;  // Clocks of two computers disagree: no arrow is better than a wrong one.
        }
        const auto put = [&](const char* phase, bus::NodeId node, double at_us) {
            Json event{{"ph", phase},
                       {"cat", "message"},
                       {"id", arrows_},
                       {"pid", node},
                       {"tid", static_cast<int>(receives)},
                       {"name", "leads to"},
                       {"ts", at_us}};
            if (*phase == 'f') {
                event["bp"] = "e";
            }
            put_counted(event);
        };
        ++arrows_;
        put("s", from, from_us);
        put("f", to, to_us);
    }

    const RecordedRun& run_;
    std::uint64_t start_ns_, left_, arrows_ = 0;
    TextOutput& output_;
    bool first_ = true;
    TimelineCounts counts_;
    std::map<std::uint32_t, FrameTimes> frames_;
    std::map<bus::NodeId, double> modelled_free_us_;
    std::map<bus::NodeId, std::map<std::uint64_t, double>> received_;  ///< Wall time by clock.
};

}  // namespace

TimelineCounts put_timeline(const RecordedRun& run, const Selection& selection,
                            std::uint64_t max_events, TextOutput& output) {
    return Timeline(run, max_events, output).put(selection);
}

}  // namespace pxpl5::host::inspect

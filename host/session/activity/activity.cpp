#include "host/session/activity/activity.hpp"

#include <algorithm>
#include <utility>

#include "host/base/stopwatch.hpp"
#include "ringbus/activity.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

constexpr double ms_per_ns = 1e-6;

double ms_between(std::uint64_t before_ns, std::uint64_t now_ns) {
    return static_cast<double>(now_ns - before_ns) * ms_per_ns;
}

std::vector<NodeReport::Stage> new_stages(const schema::ActivityT& now,
                                          const schema::ActivityT& before) {
    std::vector<NodeReport::Stage> stages;
    for (const auto& stage : now.stages) {
        const auto old = std::ranges::find_if(
            before.stages, [&](const auto& s) { return s->name == stage->name; });
        const bool is_old = old != before.stages.end();
        const std::uint64_t old_ns = is_old ? (*old)->ns : 0;
        if (stage->ns > old_ns) {
            stages.push_back(
                {stage->name, ms_between(old_ns, stage->ns),
                 static_cast<std::int64_t>(stage->count - (is_old ? (*old)->count : 0))});
        }
    }
    return stages;
}

std::vector<bus::SentCount> new_sent(const std::vector<schema::SentCount>& now,
                                     const std::vector<schema::SentCount>& before) {
    std::vector<bus::SentCount> sent;
    for (const schema::SentCount& sum : now) {
        const auto old = std::ranges::find_if(before, [&](const schema::SentCount& s) {
            return s.destination() == sum.destination() && s.kind() == sum.kind() &&
                   s.channel() == sum.channel();
        });
        const bool is_old = old != before.end();
        const std::uint64_t messages = sum.messages() - (is_old ? old->messages() : 0);
        if (messages > 0) {
            sent.push_back({sum.destination(), static_cast<bus::Body>(sum.kind()), sum.channel(),
                            messages, sum.bytes() - (is_old ? old->bytes() : 0)});
        }
    }
    return sent;
}

NodeReport new_of(const MachineNode& node, const schema::ActivityT& now,
                  const schema::ActivityT& before) {
    NodeReport report{.node = node, .answered = true};
    report.wall_ms = ms_between(before.wall_ns, now.wall_ns);
    report.cpu_ms = ms_between(before.cpu_ns, now.cpu_ns);
    report.stages = new_stages(now, before);
    for (const NodeReport::Stage& stage : report.stages) {
        report.busy_ms += stage.ms;
    }
    report.sent = new_sent(now.sent, before.sent);
    report.received_messages = now.received_messages - before.received_messages;
    report.received_bytes = now.received_bytes - before.received_bytes;
    report.refused_messages = now.refused_messages;
    report.frames = static_cast<std::int64_t>(now.frames - before.frames);
    report.memory_bytes = now.memory_bytes;
    report.queue = now.queue;
    report.held_up = now.held_up;
    return report;
}

/// The host's own answer.
schema::ActivityT own_activity(const bus::Traffic& own) {
    schema::ActivityT activity;
    activity.wall_ns = static_cast<std::uint64_t>(now_ns());
    activity.cpu_ns = bus::processor_ns();
    for (const bus::SentCount& sum : own.sent) {
        activity.sent.emplace_back(sum.to, static_cast<std::uint16_t>(sum.kind), sum.channel,
                                   sum.messages, sum.bytes);
    }
    activity.received_messages = own.received_messages;
    activity.received_bytes = own.received_bytes;
    activity.refused_messages = own.refused_messages;
    return activity;
}

}  // namespace

ActivityMonitor::ActivityMonitor(std::vector<MachineNode> nodes)
    : nodes_(std::move(nodes)), answers_(nodes_.size()), reported_ns_(now_ns()) {
    if (!nodes_.empty()) {  // The host's clock, unlike the nodes', did not begin with 0.
        answers_.front().reported.wall_ns = static_cast<std::uint64_t>(reported_ns_);
    }
}

std::vector<bus::NodeId> ActivityMonitor::ask() {
    std::vector<bus::NodeId> asked;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (nodes_[i].id != bus::host_id && !answers_[i].owes) {
            answers_[i].owes = true;
            asked.push_back(nodes_[i].id);
        }
    }
    return asked;
}

bool ActivityMonitor::awaits() const {
    return std::ranges::any_of(answers_, &Answers::owes);
}

void ActivityMonitor::take(bus::NodeId from, const schema::Activity& activity) {
    const auto node = std::ranges::find(nodes_, from, &MachineNode::id);
    if (node == nodes_.end()) {
        return;  // The host asks no io process.
    }
    Answers& answers = answers_[static_cast<std::size_t>(node - nodes_.begin())];
    answers.owes = false;
    answers.is_new = true;
    answers.newest = schema::ActivityT();
    activity.UnPackTo(&answers.newest);
}

ActivityReport ActivityMonitor::report(const bus::Traffic& own) {
    ActivityReport report{ms_since(reported_ns_), frames_ - reported_frames_, {}};
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        Answers& answers = answers_[i];
        if (nodes_[i].id == bus::host_id) {
            answers.newest = own_activity(own);
            answers.is_new = true;
        }
        if (!answers.is_new) {
            report.nodes.push_back({.node = nodes_[i]});
            report.nodes.back().memory_bytes = answers.reported.memory_bytes;
            continue;
        }
        report.nodes.push_back(new_of(nodes_[i], answers.newest, answers.reported));
        if (nodes_[i].id == bus::host_id) {
            report.nodes.back().busy_ms = report.nodes.back().cpu_ms;
        }
        answers.reported = std::move(answers.newest);
        answers.is_new = false;
    }
    reported_ns_ = now_ns();
    reported_frames_ = frames_;
    return report;
}

}  // namespace pxpl5::host

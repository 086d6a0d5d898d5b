// The main of a node process: joins the machine, drives a Node until Shutdown, reports faults.
#pragma once

#include <functional>
#include <memory>

#include "ringbus/node.hpp"

namespace pxpl5::bus {

using NodeFactory = std::function<std::unique_ptr<Node>()>;

/// Parses --host-endpoint, --bind, --role-index and --version, joins the machine as `role`, and
/// drives the node until the host says Shutdown or dies.
///
/// Returns   the exit code: 0 after Shutdown, 64 for a bad command line, 69 if the host is gone,
///           70 for an internal error.
int run_process(int argc, char** argv, schema::Role role, const NodeFactory& make_node);

}  // namespace pxpl5::bus

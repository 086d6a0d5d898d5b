#!/usr/bin/env python3
"""The manifests of host/kubernetes: test_kubernetes.py BIN_DIR [unittest's words].

Without a cluster. `kubectl set --local` reads an object into the types of Kubernetes and prints it:
what it does not print, Kubernetes does not know. The programs run with the arguments of the
manifests, on loopback.
"""
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

try:
    import yaml
except ImportError:
    sys.exit("SKIPPED: python3-yaml is not installed")

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "host/serve"))
from websocket_client import WebSocket  # noqa: E402

BIN = pathlib.Path(sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin").resolve()
FOLDER = pathlib.Path(__file__).resolve().parents[3] / "host/kubernetes"
NAMES = ("session.yaml", "jobset.yaml")
LIMIT_S = 120
NO_CLUSTER = {**os.environ, "KUBECONFIG": os.devnull, "HOME": tempfile.gettempdir()}
ANY = None  # Any value.
LABELS = {"matchLabels": ANY}
PEERS = [{"podSelector": LABELS}]
# The fields that the manifests use and kubectl has no local type for.
FIELDS = {
    "NetworkPolicy": {"podSelector": LABELS, "policyTypes": ANY, "ingress": [{"from": PEERS}],
                      "egress": [{"to": PEERS, "ports": [{"protocol": ANY, "port": ANY}]}]},
    "JobSet": {"network": {"enableDNSHostnames": ANY, "publishNotReadyAddresses": ANY},
               "successPolicy": {"operator": ANY, "targetReplicatedJobs": ANY},
               "failurePolicy": {"maxRestarts": ANY},
               "replicatedJobs": [{"name": ANY, "replicas": ANY, "template": {"spec": ANY}}]},
}
VERSIONS = {"Service": "v1", "Job": "batch/v1", "NetworkPolicy": "networking.k8s.io/v1",
            "JobSet": "jobset.x-k8s.io/v1alpha2"}


def has_kubectl():
    """True if kubectl is here and knows the Kubernetes of the manifests."""
    if not shutil.which("kubectl"):
        return False
    said = subprocess.run(["kubectl", "version", "--client", "-o", "json"], capture_output=True,
                          text=True, check=False, timeout=LIMIT_S, env=NO_CLUSTER).stdout
    return int(re.search(r'"minor": "(\d+)', said)[1]) >= 24


KUBECTL = has_kubectl()


def objects_of(text):
    return list(yaml.safe_load_all(text))


def jobs_of(objects):
    """The Jobs, those of a JobSet too, as objects of their own."""
    jobs = [each for each in objects if each["kind"] == "Job"]
    for each in objects:
        for job in each["spec"]["replicatedJobs"] if each["kind"] == "JobSet" else ():
            jobs.append({"apiVersion": "batch/v1", "kind": "Job",
                         "metadata": {"name": job["name"]}, "spec": job["template"]["spec"]})
    return jobs


def unknown(value, fields, where):
    """Paths of what `fields` does not have."""
    if fields is ANY:
        return []
    if isinstance(fields, list):
        return [path for i, each in enumerate(value)
                for path in unknown(each, fields[0], f"{where}[{i}]")]
    return [path for key, each in value.items()
            for path in (unknown(each, fields[key], f"{where}.{key}") if key in fields
                         else [f"{where}.{key}"])]


def missing(value, known, where):
    """Paths of `value` that are not in `known`."""
    if isinstance(value, dict) and isinstance(known, dict):
        return [path for key, each in value.items()
                for path in (missing(each, known[key], f"{where}.{key}") if key in known
                             else [f"{where}.{key}"])]
    if isinstance(value, list) and isinstance(known, list) and len(value) == len(known):
        return [path for i, each in enumerate(value)
                for path in missing(each, known[i], f"{where}[{i}]")]
    return [] if value == known else [f"{where}: {value} is read as {known}"]


def understood(manifest):
    """The object as kubectl has read it into its type; a text if it refuses."""
    selector = [f"{key}={value}" for key, value in manifest["spec"].get("selector", {}).items()]
    words = {"Job": ["serviceaccount", "default"], "Service": ["selector", ",".join(selector)]}
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(manifest, file)
        file.flush()
        what, value = words[manifest["kind"]]
        done = subprocess.run(
            ["kubectl", "set", what, "--local", "-f", file.name, value, "-o", "json"],
            capture_output=True, text=True, check=False, timeout=LIMIT_S, env=NO_CLUSTER)
    return json.loads(done.stdout) if done.returncode == 0 else done.stderr


def faults_of(text):
    """What is wrong with the manifests in `text`."""
    objects = objects_of(text)
    faults = []
    for each in objects:
        kind = each["kind"]
        if each["apiVersion"] != VERSIONS.get(kind):
            faults.append(f"{kind} of {each['apiVersion']}")
        faults += unknown(each["spec"], FIELDS.get(kind, ANY), kind)
        faults += [f"{kind}.{key}" for key in each.keys() - {"apiVersion", "kind", "metadata",
                                                             "spec"}]
    if KUBECTL:
        for each in [each for each in objects if each["kind"] == "Service"] + jobs_of(objects):
            read = understood(each)
            faults += missing(each, read, each["kind"]) if isinstance(read, dict) else [read]
    return faults + unsafe(objects)


def unsafe(objects):
    """What lets a pod do more than it needs, or stutter."""
    faults = []
    for job in jobs_of(objects):
        pod = job["spec"]["template"]["spec"]
        (container,) = pod["containers"]
        rights, own = pod.get("securityContext", {}), container.get("securityContext", {})
        wanted = {
            "runAsNonRoot": rights.get("runAsNonRoot") is True and rights.get("runAsUser", 0) > 0,
            "seccompProfile": rights.get("seccompProfile") == {"type": "RuntimeDefault"},
            "allowPrivilegeEscalation": own.get("allowPrivilegeEscalation") is False,
            "readOnlyRootFilesystem": own.get("readOnlyRootFilesystem") is True,
            "capabilities": own.get("capabilities") == {"drop": ["ALL"]},
            "limits": set(container["resources"]["limits"]) == {"memory"},
            "token": pod.get("automountServiceAccountToken") is False,
            # With fsGroup the files of a Secret get mode 0440, which read_key_file() accepts.
            "key": [volume["secret"] for volume in pod["volumes"] if "secret" in volume] ==
                   [{"secretName": "pxpl5-key", "defaultMode": 0o440}] and "fsGroup" in rights,
            "mounts": {each["name"] for each in container["volumeMounts"]} ==
                      {each["name"] for each in pod["volumes"]},
        }
        faults += [f"{job['metadata']['name']}: {name}" for name, holds in wanted.items()
                   if not holds]
    return faults


def words_of(objects, part):
    """The arguments of the host or the computers, and the number of their pods."""
    for job in jobs_of(objects):
        (container,) = job["spec"]["template"]["spec"]["containers"]
        if container["name"] == part:
            return container["args"], job["spec"].get("completions", 1)
    raise KeyError(part)


class Manifests(unittest.TestCase):
    def test_kubernetes_knows_every_field(self):
        for name in NAMES:
            with self.subTest(name):
                self.assertEqual(faults_of((FOLDER / name).read_text()), [])

    def check_plants(self, plants):
        for text, plant in plants:
            found = [name for name in NAMES if text in (FOLDER / name).read_text()]
            self.assertNotEqual(found, [], text)
            for name in found:
                with self.subTest(name, plant=plant):
                    manifest = (FOLDER / name).read_text().replace(text, plant, 1)
                    self.assertNotEqual(faults_of(manifest), [])

    def test_a_planted_fault_is_found(self):
        self.check_plants([
            ("policyTypes", "policyType"), ("egress:", "egres:"), ("fsGroup: 10001", "fsgroup: 1"),
            ("runAsNonRoot: true", "runAsNonRoot: false"), ("0440", "0444"),
            ("limits: { memory: 4Gi }", 'limits: { memory: 4Gi, cpu: "2" }'),
            ("maxRestarts: 1", "maxRestart: 1"), ("networking.k8s.io/v1", "networking.k8s.io/v1b"),
            ("drop: [ALL]", "drop: []"), ("name: state, mountPath", "name: gone, mountPath")])

    @unittest.skipUnless(KUBECTL, "kubectl of 1.24 or newer is not installed")
    def test_a_field_that_kubernetes_does_not_know_is_found(self):
        self.check_plants([
            ("args:", "arg:"), ("maxSkew: 1", "maxSkew: one"), ("completions: 2", "completion: 2"),
            ("restartPolicy", "restartPolice"), ("tcpSocket: { port", "tcpSocket: { ports"),
            ("emptyDir: { sizeLimit: 4Gi }", "emptyDir: { size: 4Gi }"),
            ("periodSeconds: 1", "periodSecond: 1"), ("backoffLimit: 0", "backoffLimit: none"),
            ("  publishNotReadyAddresses: true  #", "  publishNotReadyAddress: true  #")])

    def test_names_and_numbers_agree(self):
        for name in NAMES:
            objects = objects_of((FOLDER / name).read_text())
            host, _ = words_of(objects, "host")
            join, pods = words_of(objects, "computer")
            first = objects[0]
            address = {"Service": first["metadata"]["name"],
                       "JobSet": "{0}-host-0-0.{0}".format(first["metadata"]["name"])}
            self.assertIn(f"wait={pods}", host)
            self.assertEqual(join[1], f"tcp://{address[first['kind']]}:5755")
            self.assertIn("0.0.0.0:5755", host)
            for each in ("host", "computer"):
                self.assertIn("/key/key", words_of(objects, each)[0])


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pxpl5-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.env = {**os.environ, "HOME": folder.name, "TMPDIR": folder.name,
                    "XDG_RUNTIME_DIR": folder.name, "XDG_STATE_HOME": str(self.folder / "state")}
        # As Kubernetes mounts a Secret; without root its files belong to the user.
        (self.folder / "..2026").mkdir()
        (self.folder / "..data").symlink_to("..2026")
        self.key = self.folder / "key"
        self.key.symlink_to("..data/key")
        made = subprocess.run([BIN / "pxpl5", "key"], stdout=subprocess.PIPE, check=True)
        (self.folder / "..2026/key").write_bytes(made.stdout)
        (self.folder / "..2026/key").chmod(0o440 if os.geteuid() == 0 else 0o400)

    def start(self, words, **streams):
        process = subprocess.Popen([BIN / "pxpl5", *words], text=True, env=self.env, **streams)
        for stream in (process.stdout, process.stderr):
            if stream:
                self.addCleanup(stream.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def digest(self, words):
        """Process and digest of the first picture of a viewer."""
        viewer = self.start(words, stdout=subprocess.PIPE)
        said = ""
        while "Ctrl-C" not in said:
            line = viewer.stdout.readline()
            self.assertTrue(line, said)
            said += line
        page = WebSocket(re.search(r"http://\S+", said)[0])
        self.addCleanup(page.close)
        page.send(json.dumps({"id": 7, "do": "size 320x240"}))
        page.send(json.dumps({"id": 8, "do": "digest"}))
        while True:
            message = page.receive()
            reply = json.loads(message) if isinstance(message, str) else {}
            if reply.get("re") == 8:
                self.assertTrue(reply["ok"], reply)
                return viewer, reply["result"]

    def end(self, process):
        process.send_signal(signal.SIGTERM)
        return process.wait(timeout=LIMIT_S)

    def test_the_programs_take_the_arguments_of_the_manifests(self):
        alone, expected = self.digest(["serve", "phantom:pelvis"])
        self.end(alone)
        for name in NAMES:
            with self.subTest(name):
                objects = objects_of((FOLDER / name).read_text())
                with socket.socket() as free:
                    free.bind(("127.0.0.1", 0))
                    port = free.getsockname()[1]
                join, pods = words_of(objects, "computer")
                here = {"0.0.0.0:5755": f"127.0.0.1:{port}", "8080": "0", "/key/key": self.key,
                        join[1]: f"tcp://localhost:{port}"}
                computers = [self.start([here.get(word, word) for word in join],
                                        stderr=subprocess.PIPE) for _ in range(pods)]
                for each in computers:  # Before the host is up.
                    self.assertIn("waits for the host at", each.stderr.readline())
                words = words_of(objects, "host")[0]
                host, result = self.digest([here.get(word, word) for word in words])
                self.assertEqual(result, expected)
                for each in computers:
                    self.assertIn("takes part in the machine", each.stderr.readline())
                self.assertEqual(self.end(host), 0)
                for each in computers:  # They wait for the next machine.
                    self.assertEqual(self.end(each), 128 + signal.SIGTERM)


if __name__ == "__main__":
    unittest.main()

"""What the shell scripts do when things are not as they should be.

    python3 tests/lint/scripts_test.py
"""

import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class ScriptTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="penumbra-scripts-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def program(self, path, text):
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("#!/bin/sh\n" + text)
        file.chmod(0o755)

    def run_script(self, script, *arguments, status, fragment, **environment):
        run = subprocess.run([ROOT / script, *arguments], cwd=self.folder, text=True, timeout=60,
                             capture_output=True, env={**os.environ, **environment})
        self.assertEqual(run.returncode, status, run.stdout + run.stderr)
        self.assertIn(fragment, run.stdout + run.stderr)
        return run.stdout


class FuzzAllTest(ScriptTest):
    SOUND = "echo stat::number_of_executed_units: 7 >&2\n"

    def setUp(self):
        super().setUp()
        for corpus in (ROOT / "tests/fuzz/corpus").iterdir():
            self.program(f"fuzz_{corpus.name}", self.SOUND)

    def fuzz(self, **expected):
        return self.run_script("tests/fuzz/fuzz_all.py", ".", "1", **expected)

    def run_script(self, script, *arguments, **expected):
        self.program("run", f'exec python3 {ROOT / script} "$@"\n')
        return super().run_script(self.folder / "run", *arguments, **expected)

    def test_every_target_is_run(self):
        output = self.fuzz(status=0, fragment="without a finding")
        self.assertIn("scene_delta", output)

    def test_a_finding_is_told(self):
        self.program("fuzz_blob", "exit 77\n")
        self.fuzz(status=1, fragment="FINDING (status 77)")

    def test_a_target_that_is_not_run_is_told(self):
        self.program("fuzz_new", self.SOUND)
        self.fuzz(status=1, fragment="fuzz_new: no corpus")
        (self.folder / "fuzz_new").unlink()
        (self.folder / "fuzz_blob").unlink()
        self.fuzz(status=1, fragment="blob: no program fuzz_blob")

    def test_a_folder_without_targets_is_told(self):
        for program in self.folder.glob("fuzz_*"):
            program.unlink()
        self.fuzz(status=1, fragment="no program fuzz_*")


class DemoTest(ScriptTest):
    SERVER = """trap 'echo ended > {folder}/ended; exit' TERM
echo $$ > {folder}/server.pid
echo 127.0.0.1:1 > "$4"
while :; do sleep 0.05; done
"""

    def setUp(self):
        super().setUp()
        (self.folder / "room.obj").write_text("")
        self.program("b/server/penumbrad", self.SERVER.format(folder=self.folder))
        self.program("b/client/penumbra", 'echo "$@"\n')

    def demo(self, *arguments, **expected):
        return self.run_script("deploy/demo.sh", *arguments, **expected)

    def test_starts_and_stops_the_server(self):
        output = self.demo("--build-dir", "b", "room.obj", status=0, fragment="pictures: ")
        self.assertIn(f"demo {self.folder.resolve()}/room.obj --server 127.0.0.1:1", output)
        self.assertTrue((self.folder / "ended").exists())

    def test_stops_the_server_when_the_client_fails(self):
        self.program("b/client/penumbra", "echo wrong >&2; exit 3\n")
        self.demo("--build-dir", "b", "room.obj", status=3, fragment="wrong")
        self.assertTrue((self.folder / "ended").exists())

    def test_server_that_does_not_start(self):
        self.program("b/server/penumbrad", "echo no EGL >&2; exit 1\n")
        self.demo("--build-dir", "b", "room.obj", status=1, fragment="the server ended: no EGL")

    def test_interrupt(self):
        self.program("b/client/penumbra", "exec sleep 30\n")
        run = subprocess.Popen([ROOT / "deploy/demo.sh", "--build-dir", "b", "room.obj"],
                               cwd=self.folder, stdout=subprocess.DEVNULL, start_new_session=True)
        pid = self.folder / "server.pid"
        for _ in range(200):
            if pid.exists() and pid.read_text():
                break
            time.sleep(0.05)
        os.killpg(run.pid, 15)
        self.assertNotEqual(run.wait(timeout=30), 0)
        with self.assertRaises(ProcessLookupError):
            os.kill(int(pid.read_text()), 0)

    def test_bad_arguments(self):
        self.demo("no.glb", status=1, fragment="no.glb: found no such file")
        self.demo("room.obj", "room.obj", status=1, fragment="found two scenes")
        self.demo("--fast", status=1, fragment="found '--fast'")

    def test_help(self):
        self.demo("--help", status=0, fragment="deploy/demo.sh SCENE")


class InstallTest(ScriptTest):
    def install(self, *sections, status, fragment, **fakes):
        for name in ("awk", "cat", "cut", "dirname", "grep", "sh", "env"):
            link = self.folder / "bin" / name
            link.parent.mkdir(exist_ok=True)
            link.unlink(missing_ok=True)
            link.symlink_to(shutil.which(name))
        for name, text in {"dpkg-query": "exit 1", "apt-get": "exit 0", **fakes}.items():
            self.program(f"bin/{name.replace('_', '-')}", text + "\n")
        return self.run_script("deploy/install_packages.sh", *sections, status=status,
                               fragment=fragment, PATH=str(self.folder / "bin"))

    def test_nothing_missing(self):
        self.install("build", "run", status=0, fragment="packages: all there",
                     dpkg_query="printf installed", apt_get="echo called; exit 1")

    def test_neither_root_nor_sudo(self):
        self.install("build", status=1, fragment="need root or sudo to install: g++ cmake",
                     id="echo 1000")

    def test_sudo(self):
        self.install("run", status=0, fragment="packages: installed", id="echo 1000",
                     sudo='echo sudo "$@" >> log; exec "$@"', apt_get='echo "$@" >> log')
        log = (self.folder / "log").read_text()
        self.assertIn("sudo env DEBIAN_FRONTEND=noninteractive apt-get", log)
        self.assertIn("libegl1 libegl-mesa0 libgl1-mesa-dri", log)
        self.assertNotIn("update", log)

    def test_lists_are_fetched_when_those_at_hand_do_not_serve(self):
        apt = 'echo "$@" >> log\ncase "$*" in *update*) : > updated ;; *) [ -e updated ] ;; esac'
        self.install("run", status=0, fragment="packages: installed", id="echo 0", apt_get=apt)
        self.assertIn("update", (self.folder / "log").read_text())

    def test_apt_fails(self):
        self.install("run", status=1, fragment="could not install: libegl1", id="echo 0",
                     apt_get='case "$*" in *update*) ;; *) exit 100 ;; esac')

    def test_unknown_section(self):
        self.install("buidl", status=1, fragment="found section 'buidl'")

    def test_command_of_another_vendor_counts(self):
        present = 'case "$4" in npm | nodejs) exit 1 ;; esac\nprintf installed'
        self.install("test", status=0, fragment="packages: all there", dpkg_query=present,
                     npm="", node="", python3="", clang_format="")


class RunTest(ScriptTest):
    def test_bad_argument(self):
        self.run_script("tests/run.sh", "--fast", status=2, fragment="found '--fast', need --quick")


if __name__ == "__main__":
    unittest.main()

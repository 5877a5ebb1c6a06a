"""Builds test programs with one changed source file from a build without the change.

A copy of the sources below build/mutants is built once. For a program with a mutant, only the objects that include the file are compiled.
They are linked before all others: the linker uses the first definition of a duplicate function, and does not read objects of a library for
symbols that it already has. An overlay replaces the file in the copy by the changed one for the compiler (clang).
"""
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

launched = {"anogated": "src/anogated", "anoctl": "tools/anoctl"}    # the programs started by tests over the whole gateway


class Broken(Exception):
    """It does not compile: the text is the reason, `lines` the places in the changed file."""

    def __init__(self, why, lines=()):
        super().__init__(why)
        self.lines = set(lines)


def jobs():
    return int(os.environ.get("JOBS", str(os.cpu_count())))


def stem_of(path):
    return os.path.splitext(os.path.basename(path))[0]


class Tree:
    def __init__(self, root, work):
        self.root, self.tree, self.build = root, os.path.join(work, "tree"), os.path.join(work, "tree", "build", "dev")
        self.mutant = os.path.join(work, f"mutant-{os.getpid()}")
        self.commands, self.inputs, self.users, self.links = {}, {}, {}, {}

    def configure(self):
        self._copy()
        options = ["-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O0 -g0", "-DANOGATE_TESTS=ON", "-DANOGATE_UNITY=OFF", "-DANOGATE_PCH=ON",
                   "-DCMAKE_CXX_COMPILER=clang++-14", "-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld"]
        if not os.path.exists(os.path.join(self.build, "build.ninja")):
            self._run(["cmake", "-S", self.tree, "-B", self.build, "-G", "Ninja", *options])
        os.makedirs(self.mutant, exist_ok=True)

    def _copy(self):
        listed = subprocess.run(["git", "-C", self.root, "ls-files", "-co", "--exclude-standard"], check=True, capture_output=True, text=True)
        for name in listed.stdout.splitlines():
            source, target = os.path.join(self.root, name), os.path.join(self.tree, name)
            if not os.path.isfile(source):
                if os.path.isfile(target):
                    os.remove(target)
                continue
            content = open(source, "rb").read()
            if os.path.exists(target) and open(target, "rb").read() == content:
                continue
            os.makedirs(os.path.dirname(target), exist_ok=True)
            open(target, "wb").write(content)
            shutil.copymode(source, target)

    def _run(self, command):
        result = subprocess.run(command, cwd=self.build if os.path.isdir(self.build) else None, capture_output=True, text=True)
        if result.returncode != 0:
            sys.exit(f"{' '.join(command)}:\n{(result.stdout + result.stderr)[-3000:]}")
        return result.stdout

    def make(self, program):
        """Builds the program without a change, and reads which objects it consists of."""
        if program in self.inputs:
            return
        self._run(["nice", "ninja", "-C", self.build, "-j", str(jobs()), program])
        for name in [program, *launched] if program in ("integration", "attack", "threads") else [program]:
            self.inputs[name] = {p for p in self._run(["ninja", "-t", "inputs", name]).split("\n") if p.endswith(".o")}
            line = self._run(["ninja", "-t", "commands", name]).strip().split("\n")[-1]
            self.links[name] = next(shlex.split(part) for part in line.split(" && ") if " -o " in part)
        for command in json.load(open(os.path.join(self.build, "compile_commands.json"))):
            output = re.search(r" -o (\S+\.o) ", command["command"])
            if output:
                self.commands[output[1]] = command
        self._learn_users()

    def remove_mutant(self):
        shutil.rmtree(self.mutant, ignore_errors=True)

    def _learn_users(self):
        """Which objects include each of our files."""
        self.users, output = {}, None
        for line in self._run(["ninja", "-t", "deps"]).split("\n"):
            if line.startswith("    ../") or line.startswith("    " + self.tree):
                self.users.setdefault(os.path.normpath(os.path.join(self.build, line.strip())), set()).add(output)
            elif ": #deps" in line:
                output = line.split(": #deps")[0]

    def path(self, program):
        return os.path.join(self.build, self.links[program][self.links[program].index("-o") + 1])


class Mutant:
    """One changed file. `path` is its path in the sources, `text` its new content."""

    def __init__(self, tree, path, text):
        self.tree, self.file, self.objects, self.linked = tree, os.path.join(tree.tree, path), {}, {}
        tree.remove_mutant()
        os.makedirs(tree.mutant)
        changed, self.overlay = os.path.join(tree.mutant, os.path.basename(path)), os.path.join(tree.mutant, "overlay.json")
        open(changed, "w", encoding="utf-8").write(text)
        directory = {"name": os.path.dirname(self.file), "type": "directory",
                     "contents": [{"name": os.path.basename(path), "type": "file", "external-contents": changed}]}
        json.dump({"version": 0, "use-external-names": False, "roots": [directory]}, open(self.overlay, "w"))

    def users(self, program):
        return sorted(o for o in self.tree.users.get(self.file, ()) if o in self.tree.inputs[program])

    def near(self, program):
        """Of the objects that include the file: its own source, and the tests named after it or after a header that includes it."""
        users, stems = self.users(program), {stem_of(self.file)}
        for _ in range(3):
            sources = {o: self.tree.commands[o]["file"] for o in users}
            found = [o for o, s in sources.items() if "/tests/" in s and any(stem_of(s).startswith(stem) for stem in stems)]
            if found:
                return [o for o, s in sources.items() if stem_of(s) == stem_of(self.file)] + [o for o in found if stem_of(sources[o]) != stem_of(self.file)]
            stems = self._includers(stems)
        return []

    def _includers(self, stems):
        pattern = re.compile(r"#include [<\"](?:\S*/)?(?:" + "|".join(map(re.escape, stems)) + r")\.hpp[>\"]")
        return {stem_of(f) for f in self.tree.users if f.startswith(self.tree.tree) and f.endswith(".hpp")
                and "/tests/" not in f and pattern.search(open(f, encoding="utf-8").read())}

    def _compile(self, o):
        words = shlex.split(self.tree.commands[o]["command"])
        while "clang" not in os.path.basename(words[0]):    # a launcher: files compiled here are never compiled again
            words.pop(0)
        words = [w for w in words if w != "-Werror"] + ["-w", "-Wno-invalid-constexpr", "-ferror-limit=0", "-ivfsoverlay", self.overlay]
        if "-include-pch" in words:
            at = words.index("-include-pch")
            if os.path.relpath(words[at + 2], self.tree.build) in self.tree.users.get(self.file, ()):
                del words[at - 1: at + 3]
        mutated = os.path.join(self.tree.mutant, o.replace("/", "_"))
        words[words.index("-o") + 1] = mutated
        result = subprocess.run(words, cwd=self.tree.build, capture_output=True, text=True)
        if result.returncode == 0:
            return mutated
        errors = [line for line in result.stderr.splitlines() if "error:" in line]
        lines = re.findall(r"^\S*" + re.escape(os.path.basename(self.file)) + r":(\d+):\d+: (?:fatal )?error:", result.stderr, re.M)
        return Broken((errors or ["?"])[0], map(int, lines))

    def build(self, program, objects):
        """Compiles these objects of the program again and links it; returns its path."""
        new = [o for o in objects if o not in self.objects]
        with ThreadPoolExecutor(jobs()) as pool:
            for o, mutated in zip(new, pool.map(self._compile, new)):
                if isinstance(mutated, Broken):
                    raise mutated
                self.objects[o] = mutated
        mutated = {o: m for o, m in self.objects.items() if o in self.tree.inputs[program]}
        words, target = [], os.path.join(self.tree.mutant, program)
        if self.linked.get(program) == mutated:
            return target
        for word in self.tree.links[program]:
            if word.endswith(".o") and not words.count("@"):
                words.append("@")
            words.append(word)
        first = words.index("@")
        words[first: first + 1] = list(mutated.values())
        words = [w for w in words if w not in mutated]
        words[words.index("-o") + 1] = target
        result = subprocess.run(words, cwd=self.tree.build, capture_output=True, text=True)
        if result.returncode != 0:
            raise Broken("does not link: " + result.stderr[-300:])
        self.linked[program] = mutated
        return target

    def replace_launched(self):
        """Puts the mutant into the programs that tests start; returns a function that restores them."""
        saved = []
        for name in launched:
            real = self.tree.path(name)
            if self.users(name) and os.path.exists(real):
                target = self.build(name, self.users(name))
                os.rename(real, real + ".clean")
                shutil.copy(target, real)
                saved.append(real)
        return lambda: [os.replace(real + ".clean", real) for real in saved]

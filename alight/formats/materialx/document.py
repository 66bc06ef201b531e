"""Documents of MaterialX (.mtlx) -> networks of nodes.

A name refers to a node of its own graph, or to an input of that graph's interface. Nodes that a
document defines as graphs (``nodedef`` and its implementation) are replaced by these.

Source: MaterialX specification 1.39, "MaterialX nodes" and "Custom, compound and inherited nodes";
1.36 and 1.37 for ``material`` and ``shaderref``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from alight.core.errors import Issue, SceneError, quote
from alight.formats.materialx.definitions import Definitions
from alight.formats.materialx.nodes import MOST_DEEP, WIDTHS, Input, Node
from alight.formats.reading.numbers import NotNumbersError, parse_integer, parse_numbers
from alight.formats.reading.packed import text_of
from alight.formats.reading.reach import OutOfReachError, Reach
from alight.formats.reading.report import Report
from alight.formats.reading.xml import MOST_BYTES, MOST_ELEMENTS, Element, read

MOST_INCLUDES, MOST_NODES = 64, 20_000
#: Elements with inputs, in all versions.
_INPUTS = ("input", "parameter", "bindinput")
#: Elements of a document that are no nodes.
_OTHER = (
    "attributedef", "backdrop", "collection", "geominfo", "geompropdef", "implementation", "look",
    "lookgroup", "nodedef", "nodegraph", "output", "propertyset", "targetdef", "token", "typedef",
    "unitdef", "unittypedef", "variantset", "xi:include", "comment", "material", *_INPUTS,
)  # fmt: skip


@dataclass(eq=False)
class Scope:
    """A graph as used in one place.

    Attributes
    ----------
    element : Element
        The document, or a ``nodegraph``.
    interface : dict of str to Input
        What its inputs are given.
    outer : Scope or None
        Where its own name stands.
    """

    element: Element
    interface: dict[str, Input]
    outer: Scope | None
    named: dict[str, Element] = field(default_factory=dict)
    nodes: dict[str, Node] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Names of what it holds; the first of a name counts."""
        for child in self.element.children:
            if child.name:
                self.named.setdefault(child.name, child)


@dataclass
class Material:
    """A material of a document.

    Attributes
    ----------
    name, place : str
    shader : Node or None
    is_displaced : bool
    """

    name: str
    place: str
    shader: Node | None
    is_displaced: bool = False


class Document:
    """A document with what it includes.

    Parameters
    ----------
    text, name : str
        Its content, and its name for messages.
    folder : Path
        Where it lies.
    reach : Reach
        Where what it includes may lie.
    report : Report

    Raises
    ------
    SceneError
        If it is no document.
    """

    def __init__(self, text: str, name: str, folder: Path, reach: Reach, report: Report) -> None:
        self.reach, self.report = reach, report
        self.elements = self.includes = self.count = self.deep = 0
        #: Connections that are being followed.
        self._open: list[tuple[Element, Scope]] = []
        #: Element -> folder of its file, for the files that it names.
        self.folders: dict[int, Path] = {}
        root = self._read(text, name, folder)
        self.root = Scope(root, {}, None)
        self._definitions = Definitions(root, self.root.named, report)

    # ---------------------------------------------------------------- files

    def _read(self, text: str, name: str, folder: Path) -> Element:
        root, count = read(text, name, MOST_ELEMENTS - self.elements)
        self.elements += count
        if root.tag != "materialx":
            raise SceneError([Issue("", f"must be a <materialx>, got {root.label}", root.place)])
        children: list[Element] = []
        for child in root.children:
            if child.tag in ("xi:include", "include"):
                children += self._included(child, folder)
                continue
            children.append(child)
        # Attributes of a whole file hold for everything in it.
        for child in children:
            for key in ("colorspace", "fileprefix"):
                if key in root:
                    child.attributes.setdefault(key, root.attributes[key])
            self.folders.setdefault(id(child), folder)
        root.children = children
        return root

    def _included(self, element: Element, folder: Path) -> list[Element]:
        self.includes += 1
        if self.includes > MOST_INCLUDES:
            raise SceneError(
                [Issue(element.label, f"there are more than {MOST_INCLUDES} files", element.place)]
            )
        try:
            path = self.reach.from_folder(folder).find(element.attributes.get("href", ""))
            text = text_of(path, MOST_BYTES)
        except OutOfReachError as error:
            self.report.lacks(element, error, "what it includes is left out")
            return []
        return self._read(text, str(path), path.parent).children

    # ---------------------------------------------------------------- materials

    def materials(self) -> list[Material]:
        """All materials; where there is none, all surface shaders."""
        found = list(self._materials())
        if found:
            return found
        shaders = [
            child
            for child in self.root.element.children
            if child.attributes.get("type") == "surfaceshader" and child.tag not in _OTHER
        ]
        return [Material(s.name, s.place, self._node(s, self.root)) for s in shaders]

    def _materials(self) -> Iterator[Material]:
        for child in self.root.element.children:
            if child.tag == "surfacematerial":
                node = self._node(child, self.root)
                shaders = [
                    entry.source
                    for key, entry in node.inputs.items()
                    if key in ("surfaceshader", "backsurfaceshader") and entry.source is not None
                ]
                displaced = node.inputs.get("displacementshader")
                is_displaced = displaced is not None and displaced.source is not None
                yield Material(
                    child.name, child.place, shaders[0] if shaders else None, is_displaced
                )
            elif child.tag == "material":
                references = [c for c in child.children if c.tag == "shaderref"]
                nodes = [self._node(reference, self.root) for reference in references]
                yield Material(child.name, child.place, nodes[0] if nodes else None)

    # ---------------------------------------------------------------- nodes

    def _node(self, element: Element, scope: Scope) -> Node:
        """The node of an element, made once in each graph."""
        key = f"{element.name} {id(element)}"
        if key in scope.nodes:
            return scope.nodes[key]
        self.count += 1
        if self.count > MOST_NODES:
            text = f"its graphs hold more than {MOST_NODES} nodes"
            raise SceneError([Issue(element.label, text, element.place)])
        category = element.tag
        if category == "shaderref":
            category = element.attributes.get("node", "")
        node = Node(
            element.name or category,
            category,
            element.attributes.get("type", "").replace("multioutput", ""),
            element.place,
            version=element.attributes.get("version", ""),
        )
        scope.nodes[key] = node
        self.deep += 1
        if self.deep > MOST_DEEP:
            text = f"stands below more than {MOST_DEEP} nodes"
            raise SceneError([Issue(element.label, text, element.place)])
        # Its graph first: nodes of the standard library have none in a document.
        for child in element.children:
            if child.tag in _INPUTS and child.name:
                node.inputs[child.name] = self._input(child, scope, element)
        found = self._replaced(element, node, scope)
        self.deep -= 1
        return found

    def _replaced(self, element: Element, node: Node, scope: Scope) -> Node:
        """A node whose definition is a graph of the document: its output is the graph's."""
        found = self._definitions.of(node, element.attributes.get("nodedef", ""))
        if found is None:
            return node
        definition, graph = found
        interface = {
            child.name: self._input(child, self.root, definition)
            for child in self._definitions.lines(definition)
            if child.tag in _INPUTS and child.name
        }
        inner = Scope(graph, interface | node.inputs, self.root)
        outputs = {
            child.name: self._connected(child, inner, graph)
            for child in graph.children
            if child.tag == "output"
        }
        node.category, node.inputs = "dot", {}
        # A graph with one output is that output.
        for name, entry in outputs.items():
            node.inputs["in" if len(outputs) == 1 else name] = entry
        if len(outputs) > 1:
            node.category = "graph"
        if node.kind == "surfaceshader" and len(outputs) == 1:
            source = next(iter(outputs.values())).source
            if source is not None:
                scope.nodes[f"{element.name} {id(element)}"] = source
                return source
        return node

    def _input(self, element: Element, scope: Scope, owner: Element) -> Input:
        """What an input says, and of which colour space that is."""
        attributes = element.attributes
        name = attributes.get("interfacename") or attributes.get("publicname", "")
        if name and name in scope.interface:
            return self._in_space(scope.interface[name], element, owner)
        if any(key in element for key in ("nodename", "nodegraph", "output", "graph")):
            return self._connected(element, scope, owner)
        kind = attributes.get("type", "")
        top = scope.element
        space = attributes.get("colorspace") or owner.attributes.get("colorspace", "")
        space = space or top.attributes.get("colorspace", "")
        entry = Input(kind, space=space, says_space="colorspace" in element)
        text = attributes.get("value")
        if text is None or (kind == "filename" and not text.strip()):
            return entry
        if kind == "filename":
            prefix = attributes.get("fileprefix") or owner.attributes.get("fileprefix", "")
            entry.value = (prefix or top.attributes.get("fileprefix", "")) + text
            folder = self.folders.get(id(owner)) or self.folders.get(id(top))
            entry.asset = folder or self.reach.folder
            return entry
        entry.value = self._parsed(element, kind, text)
        return entry

    def _in_space(self, outer: Input, element: Element, owner: Element) -> Input:
        """What an interface is given, in the colour space of what uses it if it has none."""
        own = element.attributes.get("colorspace", "")
        if not outer.space:
            own = own or owner.attributes.get("colorspace", "")
        return outer if outer.says_space or not own else replace(outer, space=own)

    def _parsed(self, element: Element, kind: str, text: str) -> Any:
        try:
            if kind == "boolean":
                return text.strip().lower() in ("true", "1")
            if kind == "integer":
                return parse_integer(text)
            if kind in WIDTHS:
                numbers = tuple(parse_numbers(text, WIDTHS[kind]))
                return numbers[0] if kind == "float" else numbers
        except NotNumbersError as error:
            self.report.error(element, str(error))
            return None
        return text

    def _connected(self, element: Element, scope: Scope, owner: Element) -> Input:
        """What an input or an output of a graph is connected to."""
        if any(e is element and s is scope for e, s in self._open):
            raise SceneError([Issue(element.label, "is connected to itself", element.place)])
        if len(self._open) == 2 * MOST_DEEP:
            text = f"is connected through more than {2 * MOST_DEEP} others"
            raise SceneError([Issue(element.label, text, element.place)])
        self._open.append((element, scope))
        try:
            entry = self._followed(element, scope, owner)
        finally:
            self._open.pop()
        letters = element.attributes.get("channels", "")
        if letters[1:] and any(order.startswith(letters) for order in ("rgba", "xyzw")):
            return entry
        if not letters or (entry.source is None and entry.value is None):
            return entry
        # Up to 1.38 an input may take channels of what it is connected to.
        kind = element.attributes.get("type", "")
        whole = entry if entry.source is None else replace(entry, kind="")
        inputs = {"in": whole, "channels": Input("string", letters)}
        return Input(kind, source=Node(element.name, "swizzle", kind, element.place, inputs))

    def _followed(self, element: Element, scope: Scope, owner: Element) -> Input:
        attributes = element.attributes
        entry = Input(attributes.get("type", ""))
        name, graph = attributes.get("nodename"), attributes.get("nodegraph")
        output = attributes.get("output", "")
        if graph is not None:
            return self._of_graph(element, graph, output, scope)
        if name is None:
            interface = attributes.get("interfacename", "")
            if interface in scope.interface:
                return scope.interface[interface]
            # 1.37: the output of the document that has this name.
            target = self.root.named.get(output)
            if target is not None and target.tag == "output":
                return self._connected(target, self.root, self.root.element)
            return entry
        target = scope.named.get(name)
        if target is None and scope is not self.root:
            target = self.root.named.get(name)
            scope = self.root if target is not None else scope
        if target is None:
            known = ", ".join(sorted(scope.named)[:20])
            self.report.error(element, f"there is no node {quote(name)}  (nodes: {known})")
            return entry
        if target.tag == "nodegraph":
            return self._of_graph(element, name, output, scope)
        entry.source = self._node(target, scope)
        entry.output = output
        if entry.source.category == "graph":
            return entry.source.inputs.get(output, Input())
        return entry

    def _of_graph(self, element: Element, name: str, output: str, scope: Scope) -> Input:
        """An output of a graph of the document."""
        graph = self.root.named.get(name)
        if graph is None or graph.tag != "nodegraph":
            self.report.error(element, f"there is no nodegraph {quote(name)}")
            return Input(element.attributes.get("type", ""))
        inner = self._graph_scope(graph)
        outputs = [child for child in graph.children if child.tag == "output"]
        chosen = [child for child in outputs if child.name == output] if output else outputs
        if not chosen:
            text = f"the nodegraph {quote(name)} has no output {quote(output)}"
            self.report.error(element, text)
            return Input(element.attributes.get("type", ""))
        return self._connected(chosen[0], inner, graph)

    def _graph_scope(self, graph: Element) -> Scope:
        known = self._scopes.get(id(graph))
        if known is None:
            known = self._scopes[id(graph)] = Scope(graph, {}, self.root)
            for child in graph.children:
                if child.tag in _INPUTS and child.name:
                    known.interface[child.name] = self._input(child, self.root, graph)
        return known

    @property
    def _scopes(self) -> dict[int, Scope]:
        return self.__dict__.setdefault("_known_scopes", {})

"""Nodes that a document defines: ``nodedef``, and the graphs that implement them.

Source: MaterialX specification 1.39, "Custom, compound and inherited nodes".
"""

from __future__ import annotations

from alight.core.errors import Issue, SceneError, quote
from alight.formats.materialx.nodes import Node
from alight.formats.reading.report import Report
from alight.formats.reading.xml import Element


class Definitions:
    """The definitions of a document.

    Parameters
    ----------
    root : Element
        The document.
    named : dict of str to Element
        What it holds, by name.
    report : Report
    """

    def __init__(self, root: Element, named: dict[str, Element], report: Report) -> None:
        self.named, self.report = named, report
        self._definitions: dict[tuple[str, str], list[Element]] = {}
        self._graphs: dict[str, Element] = {}
        for child in root.children:
            if child.tag == "nodedef" and "node" in child:
                key = child.attributes["node"], self._kind_of(child)
                self._definitions.setdefault(key, []).append(child)
            if child.tag == "nodegraph" and "nodedef" in child:
                self._graphs[child.attributes["nodedef"]] = child
            if child.tag == "implementation" and "nodegraph" in child:
                graph = named.get(child.attributes["nodegraph"])
                if graph is not None:
                    self._graphs.setdefault(child.attributes.get("nodedef", ""), graph)

    def of(self, node: Node, name: str) -> tuple[Element, Element] | None:
        """The definition of a node, and its graph; None where it has none.

        Parameters
        ----------
        node : Node
        name : str
            Of the definition, empty where the node says none.
        """
        definition = self.named.get(name) if name else None
        if definition is None:
            definition = self._chosen(node)
        graph = None if definition is None else self._graphs.get(definition.name)
        return None if definition is None or graph is None else (definition, graph)

    def _chosen(self, node: Node) -> Element | None:
        """Of the version that a node wants, else the default one, else the first."""
        found = self._definitions.get((node.category, node.kind), [])
        for key, wanted in (("version", node.version), ("isdefaultversion", "true")):
            for definition in found:
                if wanted and definition.attributes.get(key) == wanted:
                    return definition
        return found[0] if found else None

    def lines(self, definition: Element) -> list[Element]:
        """The inputs and outputs of a definition, those that it inherits first.

        Raises
        ------
        SceneError
            If it inherits from itself.
        """
        chain = [definition]
        while parent := chain[-1].attributes.get("inherit", ""):
            above = self.named.get(parent)
            if above is None or above.tag != "nodedef":
                text = f"there is no nodedef {quote(parent)}: nothing is inherited"
                self.report.approximate(f"{definition.place}: {definition.name}: {text}")
                break
            if any(one is above for one in chain):
                raise SceneError([Issue(above.label, "inherits from itself", above.place)])
            chain.append(above)
        return [child for one in reversed(chain) for child in one.children]

    def _kind_of(self, definition: Element) -> str:
        outputs = {c.name: c for c in self.lines(definition) if c.tag == "output"}
        if len(outputs) == 1:
            return next(iter(outputs.values())).attributes.get("type", "")
        return definition.attributes.get("type", "").replace("multioutput", "")

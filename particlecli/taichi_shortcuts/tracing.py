"""Tracing kernels with less ado.

Taichi walks the syntax tree of a kernel, and that of a function at each of its calls. Every process does that, also for
kernels that the cache has compiled. Taichi's own way parses a function's source at each call, lays out the source of
every node in lines of 80 characters in case there is something to say about it, searches all modules for the source
around every decorator, and formats the stack for every field. Here a file is parsed once, and statements are the
smallest things that messages tell of.
"""

from __future__ import annotations

import ast
import copy
import linecache
import sys
import warnings
from collections.abc import Callable
from functools import cached_property
from types import CodeType
from typing import Any


def take() -> None:
    """Let Taichi trace like that, in this process."""
    from taichi.lang import impl, kernel_impl, snode
    from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext, Builder

    trees = _Trees()
    kernel_impl._get_tree_and_ctx = _prepare(trees, kernel_impl._get_tree_and_ctx)
    kernel_impl.transform_tree = _transform(trees, kernel_impl.transform_tree)
    kernel_impl._inside_class = _inside_class
    ASTTransformerContext.get_pos_info = _position
    Builder.__call__ = _build(Builder.__call__)
    for module in (impl, snode):
        module.get_traceback = lambda stacklevel=1: ""  # noqa: ARG005 - keeps Taichi's signature
    warnings.filterwarnings("ignore", message=".*Calling non-taichi function.*")
    warnings.filterwarnings("ignore", message=".*List is a built-in.*")


class _Definition:
    """A function's syntax tree, and its nodes, in which Taichi leaves what they stand for while it walks."""

    def __init__(self, node: ast.FunctionDef) -> None:
        self.node = node

    @cached_property
    def _nodes(self) -> list[Any]:
        return list(ast.walk(self.node))

    def forget(self) -> None:
        """Let go of what was left: it keeps objects alive."""
        for node in self._nodes:
            node.ptr = None


class _Trees:
    """Syntax trees of functions. Only one walk may use a tree at a time."""

    def __init__(self) -> None:
        self._files: dict[str, ast.Module] = {}
        self._known: dict[CodeType, _Definition | None] = {}
        self._walked: list[CodeType] = []
        self._used: dict[CodeType, _Definition] = {}

    def of(self, code: CodeType) -> ast.Module | None:
        """A tree whose nodes are shared but for the definition itself; none where there is no source."""
        walked = code in self._walked
        definition = _find(_parse(code.co_filename), code) if walked else self._definition(code)
        if definition is None:
            return None
        own = copy.copy(definition.node)
        own.args, own.decorator_list = copy.copy(own.args), []
        return ast.Module([own], [])

    def _definition(self, code: CodeType) -> _Definition | None:
        file = code.co_filename
        if code not in self._known:
            if file not in self._files:
                self._files[file] = _parse(file)
            self._known[code] = _find(self._files[file], code)
        definition = self._known[code]
        if definition:
            self._used[code] = definition
        return definition

    def walk(self, code: CodeType, way: Callable[[], Any]) -> Any:
        """The result of walking the tree of a function; the outermost walk ends with nothing left in any tree."""
        self._walked.append(code)
        try:
            return way()
        finally:
            self._walked.pop()
            if not self._walked:
                for definition in self._used.values():
                    definition.forget()
                self._used.clear()


def _parse(file: str) -> ast.Module:
    return ast.parse("".join(linecache.getlines(file)))


def _find(tree: ast.AST, code: CodeType) -> _Definition | None:
    """The definition of a function, which begins with its first decorator, in a file."""
    line = code.co_firstlineno
    for node in ast.iter_child_nodes(tree):
        if not isinstance(node, ast.stmt):
            continue
        decorators = node.decorator_list if isinstance(node, ast.FunctionDef | ast.ClassDef) else []
        first = min([node.lineno, *(each.lineno for each in decorators)])
        if first == line and isinstance(node, ast.FunctionDef):
            return _Definition(node)
        if first <= line <= (node.end_lineno or line):
            return _find(node, code)
    return None


def _prepare(trees: _Trees, taichis: Callable[..., Any]) -> Callable[..., Any]:
    """As `kernel_impl._get_tree_and_ctx`, which is `taichis`."""
    from taichi.lang import kernel_impl

    def prepare(
        self: Any, excluded_parameters: Any = (), is_kernel: bool = True, arg_features: Any = None, args: Any = None,
        ast_builder: Any = None, is_real_function: bool = False,
    ) -> Any:  # fmt: skip
        code = self.func.__code__
        tree = trees.of(code)
        if tree is None:
            return taichis(self, excluded_parameters, is_kernel, arg_features, args, ast_builder, is_real_function)
        known = kernel_impl._get_global_vars(self.func)
        if is_kernel or is_real_function:
            known |= {self.arguments[place].name: args[place] for place in self.template_slot_locations}
        return tree, kernel_impl.ASTTransformerContext(
            excluded_parameters=excluded_parameters,
            is_kernel=is_kernel,
            func=self,
            arg_features=arg_features,
            global_vars=known,
            argument_data=args,
            src=[""],
            start_lineno=1,
            file=code.co_filename,
            ast_builder=ast_builder,
            is_real_function=is_real_function,
        )

    return prepare


def _transform(trees: _Trees, taichis: Callable[..., Any]) -> Callable[..., Any]:
    """As `transform_tree`, which is `taichis`."""

    def transform(tree: ast.Module, context: Any) -> Any:
        return trees.walk(context.func.func.__code__, lambda: taichis(tree, context))

    return transform


def _build(taichis: Callable[..., Any]) -> Callable[..., Any]:
    """As `Builder.__call__`, which is `taichis` and takes statements."""
    ways: dict[type, Any] = {}

    def build(self: Any, context: Any, node: ast.AST) -> Any:
        kind = type(node)
        if kind not in ways:
            ways[kind] = getattr(self, f"build_{kind.__name__}", None)
        way = ways[kind]
        if way is None or isinstance(node, ast.stmt):
            return taichis(self, context, node)
        return way(context, node)

    return build


def _position(context: Any, node: Any) -> str:
    return f'File "{context.file}", line {node.lineno + context.lineno_offset}, in {context.func.func.__name__}:\n'


def _inside_class(level_of_class_stackframe: int) -> bool:
    """Whether the frame below, where a decorator is applied, is the body of a class."""
    return "__qualname__" in sys._getframe(level_of_class_stackframe - 1).f_locals

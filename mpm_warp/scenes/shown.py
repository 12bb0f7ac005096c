"""How a scene is shown at the Python prompt and in Jupyter: by what differs from its defaults."""

from mpm_warp.fields import Derived, Parameter, parameters_of
from mpm_warp.jupyter import html_table


class ShownByParameters:
    """Texts of a scene with those parameters that differ from their defaults."""

    def __init_subclass__(cls, **options: object) -> None:
        """Give each scene the text below, in place of the one that `dataclass` makes."""
        super().__init_subclass__(**options)
        if "__repr__" not in vars(cls):
            cls.__repr__ = ShownByParameters.__repr__  # type: ignore[method-assign]

    def __repr__(self) -> str:
        """The scene as it can be typed."""
        given = ", ".join(f"{it.name}={getattr(self, it.name)!r}" for it in self._given())
        return f"{type(self).__name__}({given})"

    def _repr_html_(self) -> str:
        """The same as a table, with units and meanings."""
        rows = (
            (it.name, getattr(self, it.name), "" if it.unit == "1" else it.unit, it.meaning)
            for it in self._given()
        )
        return html_table(type(self).__name__, [*rows, ("all others", "by default")])

    def _given(self) -> list[Parameter]:
        """Definitions of the parameters that differ from their defaults and are not derived."""
        return [
            definition
            for name, definition in parameters_of(type(self)).items()
            if not isinstance(value := getattr(self, name), Derived) and value != definition.default
        ]

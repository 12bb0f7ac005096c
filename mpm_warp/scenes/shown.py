"""How a scene is shown at the Python prompt and in Jupyter: by what differs from its defaults."""

from mpm_warp.fields.declaration import Derived, Parameter, Value
from mpm_warp.fields.flat import flat_values
from mpm_warp.jupyter import html_table


class ShownByParameters:
    """Texts of a scene with those parameters that differ from their defaults."""

    def __init_subclass__(cls, **options: object) -> None:
        """Give each scene the text below, in place of the one that `dataclass` makes."""
        super().__init_subclass__(**options)
        if "__repr__" not in vars(cls):
            cls.__repr__ = ShownByParameters.__repr__  # type: ignore[method-assign]

    def __repr__(self) -> str:
        """The scene as it can be typed; a law is a table."""
        names = dict.fromkeys(it.name.partition(".")[0] for it, _ in self._given())
        given = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"{type(self).__name__}({given})"

    def _repr_html_(self) -> str:
        """The same as a table, with units and meanings."""
        rows = (
            (it.name, value, "" if it.unit == "1" else it.unit, it.meaning)
            for it, value in self._given()
        )
        return html_table(type(self).__name__, [*rows, ("all others", "by default")])

    def _given(self) -> list[tuple[Parameter, Value | None]]:
        """Parameters that differ from their defaults and are not derived, in flat form."""
        return [
            (definition, value)
            for definition, value in flat_values(self).values()
            if not isinstance(value, Derived) and value != definition.default
        ]

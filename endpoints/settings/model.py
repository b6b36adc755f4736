"""Typed model of the settings of a command, by pydantic-settings: a variable goes before the file."""

from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import ValidationError, ValidatorFunctionWrapHandler, WrapValidator, create_model
from pydantic.fields import FieldInfo
from pydantic_settings import BaseSettings, EnvSettingsSource, PydanticBaseSettingsSource, SettingsConfigDict

from endpoints.settings.setting import PREFIX, Setting


class VariableText(str):
    """Text of a variable, which is read as the text of an option is."""

    __slots__ = ()


class VariableSource(EnvSettingsSource):
    """Source of the texts of variables, without those that Kubernetes sets."""

    def prepare_field_value(self, field_name: str, field: FieldInfo, value: Any, value_is_complex: bool) -> Any:
        """Mark the text of a variable."""
        assert issubclass(self.settings_cls, CommandSettings)
        found = self.settings_cls.variables.get(f"{PREFIX}{field_name.upper()}")
        return None if found is None else VariableText(found)


class CommandSettings(BaseSettings):
    """Settings of a command. The values of the file are the arguments."""

    variables: ClassVar[Mapping[str, str]] = {}
    """Variables of this project."""

    model_config = SettingsConfigDict(
        env_prefix=PREFIX, env_ignore_empty=True, extra="forbid", strict=True, validate_default=False
    )

    @classmethod
    def settings_customise_sources(
        cls, settings_cls: type[BaseSettings], init_settings: PydanticBaseSettingsSource, *_: Any, **__: Any
    ) -> tuple[PydanticBaseSettingsSource, ...]:
        """Let variables go before the file."""
        return VariableSource(settings_cls), init_settings


def model_of(settings: Collection[Setting], variables: Mapping[str, str]) -> type[CommandSettings]:
    """Return the model of the settings of a command, which takes the values of some variables."""
    fields: dict[str, Any] = {
        setting.field: (Annotated[setting.form, WrapValidator(_reader(setting))], None) for setting in settings
    }
    model = create_model("SettingsOfCommand", __base__=CommandSettings, **fields)
    model.variables = variables
    return model


def read_values(
    settings: Collection[Setting], file: Mapping[str, Any], variables: Mapping[str, str]
) -> tuple[dict[Setting, Any], dict[Setting, str]]:
    """Return the values of settings from variables and a table of a file, and what is wrong with others."""
    by_field = {setting.field: setting for setting in settings}
    given = {setting.field: file[setting.name] for setting in settings if setting.name in file}
    try:
        model = model_of(settings, variables)(**given)
    except ValidationError as error:
        faults = {by_field[str(fault["loc"][0])]: _words_on(fault) for fault in error.errors(include_input=False)}
        return {}, faults
    return {by_field[name]: getattr(model, name) for name in model.model_fields_set}, {}


def _reader(setting: Setting) -> Callable[[Any, ValidatorFunctionWrapHandler], Any]:
    def read(value: Any, check: ValidatorFunctionWrapHandler) -> Any:
        return setting.from_text(value) if isinstance(value, VariableText) else setting.from_file(check(value))

    return read


def _words_on(fault: Any) -> str:
    inner = ".".join(map(str, fault["loc"][1:]))
    words = str(fault["msg"]).removeprefix("Value error, ")
    return f"{inner}: {words}" if inner else words

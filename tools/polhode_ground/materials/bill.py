"""Materials as a CycloneDX document."""

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model import Property
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL

from polhode_ground.common.whole_file import MARK

from .material import Material


def component_of(material: Material) -> Component:
    factory = LicenseFactory()
    expressions = [factory.make_from_string(text) for text in material.licences]
    if len(expressions) > 1:  # of several, none may be an expression: each is named by its text
        expressions = [
            factory.make_with_name(text) if not hasattr(made, "name") else made for text, made in zip(material.licences, expressions)
        ]
    return Component(
        name=material.name,
        version=material.version,
        type=ComponentType.LIBRARY,
        licenses=expressions,
        bom_ref=material.purl,
        purl=PackageURL.from_string(material.purl),
        properties=[Property(name="polhode:use", value=material.use)],
    )


def write_bill(version: str, *groups: list[Material]) -> str:
    root = Component(
        name="polhode",
        version=version,
        type=ComponentType.APPLICATION,
        bom_ref="polhode",
        licenses=[LicenseFactory().make_from_string("Apache-2.0")],
    )
    bill = Bom()
    bill.metadata.component = root
    bill.metadata.properties.add(Property(name="polhode:note", value=MARK))
    materials = [material for group in groups for material in group]
    components = {material.purl: component_of(material) for material in materials}
    bill.components.update(components.values())
    bill.register_dependency(root, [components[material.purl] for material in materials if material.direct])
    for material in materials:
        bill.register_dependency(components[material.purl], [components[need] for need in material.needs])
    return JsonV1Dot6(bill).output_as_string(indent=2) + "\n"

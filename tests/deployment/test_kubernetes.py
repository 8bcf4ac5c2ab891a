"""The manifests are what Kubernetes admits, agree with image and command line, and run with the least rights."""

from __future__ import annotations

import re
from typing import Any

import kubernetes_validate
import pytest
from ruamel.yaml import YAML

from geoswarm.environment import SECRETS
from tests.contracts.repository import ROOT
from tests.contracts.test_compose import parsed

FOLDER = ROOT / "deploy" / "kubernetes"
VERSIONS = ("1.29", "1.31", "1.33", "1.35", "1.37")
POD_KINDS = ("Deployment", "CronJob")


def kustomization() -> dict[str, Any]:
    found: dict[str, Any] = YAML(typ="safe").load((FOLDER / "kustomization.yaml").read_text(encoding="utf-8"))
    return found


def manifests() -> list[dict[str, Any]]:
    files = [FOLDER / name for name in kustomization()["resources"]]
    yaml = YAML(typ="safe")
    return [document for file in files for document in yaml.load_all(file.read_text(encoding="utf-8"))]


MANIFESTS = manifests()


def label(manifest: dict[str, Any]) -> str:
    return f"{manifest['kind']}-{manifest['metadata']['name']}"


def pod(manifest: dict[str, Any]) -> dict[str, Any]:
    spec = manifest["spec"]
    template = spec["jobTemplate"]["spec"]["template"] if manifest["kind"] == "CronJob" else spec["template"]
    return dict(template)


def of_kind(*kinds: str) -> list[dict[str, Any]]:
    return [manifest for manifest in MANIFESTS if manifest["kind"] in kinds]


pods = pytest.mark.parametrize("manifest", of_kind(*POD_KINDS), ids=label)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("manifest", MANIFESTS, ids=label)
def test_kubernetes_admits_them(manifest: dict[str, Any], version: str) -> None:
    kubernetes_validate.validate(manifest, version, strict=True)
    assert manifest["apiVersion"]


def test_the_validator_refuses_what_is_wrong() -> None:
    """Else the test above would say nothing."""
    for wrong in ({"replica": 2}, {"replicas": "two"}):
        (api, *_) = of_kind("Deployment")
        changed = api | {"spec": api["spec"] | wrong}
        with pytest.raises(kubernetes_validate.ValidationError):
            kubernetes_validate.validate(changed, VERSIONS[-1], strict=True)


def test_every_file_is_put_together_and_nothing_twice() -> None:
    files = {path.name for path in FOLDER.glob("*.yaml")} - {"kustomization.yaml"}
    assert set(kustomization()["resources"]) == files
    names = [label(manifest) for manifest in MANIFESTS]
    assert len(names) == len(set(names))
    assert kustomization()["namespace"] in [m["metadata"]["name"] for m in of_kind("Namespace")]


@pods
def test_pods_run_commands_that_exist(manifest: dict[str, Any]) -> None:
    (container,) = pod(manifest)["spec"]["containers"]
    assert parsed(container["args"]).info_name == container["name"].replace("api", "serve")
    assert container["image"] == kustomization()["images"][0]["name"] == "geoswarm"


@pods
def test_pods_have_no_right_that_they_do_not_need(manifest: dict[str, Any]) -> None:
    spec = pod(manifest)["spec"]
    (container,) = spec["containers"]
    user = re.search(r"useradd .*--uid (\d+)", (ROOT / "Dockerfile").read_text(encoding="utf-8"))
    assert user is not None
    security = spec["securityContext"]
    assert security["runAsNonRoot"] is True
    assert security["runAsUser"] == security["runAsGroup"] == security["fsGroup"] == int(user[1])
    assert security["seccompProfile"] == {"type": "RuntimeDefault"}
    assert container["securityContext"] == {
        "readOnlyRootFilesystem": True,
        "allowPrivilegeEscalation": False,
        "capabilities": {"drop": ["ALL"]},
    }
    assert spec["automountServiceAccountToken"] is False
    assert spec["enableServiceLinks"] is False
    assert set(container["resources"]) == {"requests", "limits"}
    assert set(container["resources"]["limits"]) == {"cpu", "memory"}
    writable = [m for m in container["volumeMounts"] if not m.get("readOnly")]
    assert [m["mountPath"] for m in writable] == ["/tmp"]


@pods
def test_secrets_are_files_that_the_pod_needs(manifest: dict[str, Any]) -> None:
    spec = pod(manifest)["spec"]
    (container,) = spec["containers"]
    (mount,) = (m for m in container["volumeMounts"] if m["name"] == "secrets")
    (volume,) = (v for v in spec["volumes"] if v["name"] == "secrets")
    given = {f"{mount['mountPath']}/{item['path']}" for item in volume["secret"]["items"]}
    named = {e["value"] for e in container["env"] if e["name"].endswith("_FILE")}
    assert named == given
    assert {e["name"].removesuffix("_FILE") for e in container["env"] if e["name"].endswith("_FILE")} <= set(SECRETS)
    assert volume["secret"]["defaultMode"] == 0o440
    keys = set(re.findall(r"--from-literal=(\w+)=", (FOLDER / "README.md").read_text(encoding="utf-8")))
    assert {item["key"] for item in volume["secret"]["items"]} <= keys


@pytest.mark.parametrize("manifest", of_kind("Deployment"), ids=label)
def test_lasting_pods_are_looked_after(manifest: dict[str, Any]) -> None:
    (container,) = pod(manifest)["spec"]["containers"]
    probe = container["livenessProbe"]
    if "httpGet" in probe:
        assert container["readinessProbe"]["httpGet"]["path"] == "/health/ready"
        assert probe["httpGet"]["path"] == "/health/live"
        (port,) = container["ports"]
        assert str(port["containerPort"]) in container["args"]
    else:
        assert probe["exec"]["command"][:3] == ["python", "-m", "geoswarm.workers.hosts.healthcheck"]
        assert probe["timeoutSeconds"] > 10


def test_selectors_find_their_pods() -> None:
    labels = [pod(manifest)["metadata"]["labels"] for manifest in of_kind(*POD_KINDS)]
    for manifest in of_kind("Deployment", "PodDisruptionBudget"):
        assert manifest["spec"]["selector"]["matchLabels"] in labels
    for manifest in of_kind("Service"):
        assert manifest["spec"]["selector"] in labels
    for manifest in of_kind("NetworkPolicy"):
        selector = manifest["spec"]["podSelector"]
        for found in labels if manifest["metadata"]["name"] == "geoswarm-nothing" else labels[:1]:
            assert selector.get("matchLabels", {}).items() <= found.items()
    assert len({tuple(sorted(found.items())) for found in labels}) == len(labels) == 4


def test_workers_are_scaled_by_what_is_open_and_nothing_else() -> None:
    (scaler,) = of_kind("HorizontalPodAutoscaler")
    (worker,) = (m for m in of_kind("Deployment") if m["metadata"]["name"] == scaler["spec"]["scaleTargetRef"]["name"])
    assert "replicas" not in worker["spec"]
    (container,) = pod(worker)["spec"]["containers"]
    processes = container["args"][container["args"].index("--concurrency") + 1]
    (metric,) = scaler["spec"]["metrics"]
    assert metric["external"]["target"]["averageValue"] == processes == container["resources"]["limits"]["cpu"]
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert f"name: {{as: {metric['external']['metric']['name']}}}" in readme
    assert {"geoswarm_queue_depth", "geoswarm_evaluations_running"} <= set(re.findall(r"geoswarm_\w+", readme))


def test_nothing_goes_in_or_out_that_is_not_named() -> None:
    policies = {manifest["metadata"]["name"]: manifest["spec"] for manifest in of_kind("NetworkPolicy")}
    assert policies["geoswarm-nothing"]["policyTypes"] == ["Ingress", "Egress"]
    assert not {"ingress", "egress"} & set(policies["geoswarm-nothing"])
    ingress = [spec for spec in policies.values() if spec.get("ingress")]
    (rule,) = (rule for spec in ingress for rule in spec["ingress"])
    assert rule["ports"] == [{"protocol": "TCP", "port": 8765}]

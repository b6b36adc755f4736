{{- define "ppaas.name" -}}
{{- .Release.Name | trunc 40 | trimSuffix "-" -}}
{{- end }}

{{/* Labels by which pods are found: they can never change. */}}
{{- define "ppaas.selector" -}}
app.kubernetes.io/name: ppaas
app.kubernetes.io/instance: {{ .Release.Name }}
{{- end }}

{{- define "ppaas.labels" -}}
{{ include "ppaas.selector" . }}
app.kubernetes.io/version: {{ .Chart.AppVersion | quote }}
app.kubernetes.io/managed-by: {{ .Release.Service }}
helm.sh/chart: {{ printf "%s-%s" .Chart.Name .Chart.Version | replace "+" "_" }}
{{- end }}

{{/* The pods whose endpoints serve clients: those of machines, and of the master if it is alone. */}}
{{- define "ppaas.serves" -}}
ppaas/serves: clients
{{- end }}

{{/* Addresses of all masters for machines. */}}
{{- define "ppaas.masters" -}}
{{- $name := include "ppaas.name" . -}}
{{- $found := list -}}
{{- range until (int .Values.master.replicas) -}}
{{- $found = append $found (printf "%s-master-%d.%s-masters.%s.svc:8510" $name . $name $.Release.Namespace) -}}
{{- end -}}
{{- toJson $found -}}
{{- end }}

{{/* A table of ppaas.toml. Numbers of values are floats: those that are whole are written so. */}}
{{- define "ppaas.table" -}}
{{- regexReplaceAll "(?m)= (-?[0-9]+)\\.0$" (toToml .) "= ${1}" -}}
{{- end }}

{{/* What the values must agree on. */}}
{{- define "ppaas.check" -}}
{{- $several := or (gt (int .Values.master.replicas) 1) (ne .Values.machines.kind "none") -}}
{{- if and $several (not .Values.stores.urlSecret) -}}
{{- fail "machines and a standby need stores that all reach: stores.urlSecret" -}}
{{- end -}}
{{- if and $several (not .Values.machines.joinSecret) -}}
{{- fail "machines and a standby join with a secret: machines.joinSecret" -}}
{{- end -}}
{{- if and (gt (int .Values.master.replicas) 1) (not .Values.master.passwordSecret) -}}
{{- fail "a leader and a standby need the same password: master.passwordSecret" -}}
{{- end -}}
{{- if and (gt (int .Values.master.replicas) 1) (or (eq .Values.machines.kind "none") (lt (int .Values.machines.endpoints) 1)) -}}
{{- fail "with a standby, endpoints of machines serve clients: machines.kind and machines.endpoints" -}}
{{- end -}}
{{- end }}

{{/* Fields of a pod that masters and machines share. */}}
{{- define "ppaas.pod" -}}
automountServiceAccountToken: false
enableServiceLinks: false
# Its first process reaps what others leave.
shareProcessNamespace: true
terminationGracePeriodSeconds: 30
securityContext:
  runAsNonRoot: true
  runAsUser: 10001
  runAsGroup: 10001
  fsGroup: 10001
  # The folder of the data alone: the files in it are private.
  fsGroupChangePolicy: OnRootMismatch
  seccompProfile: {type: RuntimeDefault}
{{- with .Values.image.pullSecrets }}
imagePullSecrets:
  {{- toYaml . | nindent 2 }}
{{- end }}
initContainers:
  - name: kernels
    {{- include "ppaas.image" . | nindent 4 }}
    command: [cp, --recursive, --no-clobber, /opt/ppaas/kernels/., /kernels]
    {{- include "ppaas.confined" . | nindent 4 }}
    resources:
      requests: {cpu: 100m, memory: 64Mi}
      limits: {memory: 256Mi}
    volumeMounts:
      - {name: kernels, mountPath: /kernels}
{{- end }}

{{- define "ppaas.image" -}}
image: "{{ .Values.image.repository }}:{{ .Values.image.tag | default .Chart.AppVersion }}"
imagePullPolicy: {{ .Values.image.pullPolicy }}
{{- end }}

{{- define "ppaas.confined" -}}
securityContext:
  allowPrivilegeEscalation: false
  readOnlyRootFilesystem: true
  capabilities: {drop: [ALL]}
{{- end }}

{{/* What must be written beside the data: compiled kernels, sockets, layers of maps. */}}
{{- define "ppaas.written" -}}
- {name: kernels, mountPath: /opt/ppaas/kernels}
- {name: sockets, mountPath: /tmp}
- {name: layers, mountPath: /dev/shm}
- {name: settings, mountPath: /etc/ppaas, readOnly: true}
{{- end }}
